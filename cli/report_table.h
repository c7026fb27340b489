#pragma once

#include <string>

#include "remaps/pipeline/report.h"

namespace remaps::cli {

/// What a run did, in some ten lines for people.
std::string report_table(const pipeline::Report& report);

}  // namespace remaps::cli
