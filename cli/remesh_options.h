#pragma once

#include "options.h"
#include "remaps/pipeline/remesh.h"

namespace remaps::cli {

/// --weld, --strict, --min-component, --fill-holes: how a mesh is taken in.
void add_repair_options(CLI::App& verb, pipeline::RemeshOptions& options);
/// --memory, --threads, --temp-dir, --domain-buffer, --map-buffer.
void add_buffer_options(CLI::App& verb, pipeline::RemeshOptions& options);

}  // namespace remaps::cli
