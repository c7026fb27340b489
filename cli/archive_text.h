#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "remaps/pipeline/codec_files.h"

namespace remaps::cli {

/// The names of wavelets on the command line and in reports.
std::vector<std::string> wavelet_names();
std::string name_of(codec::Wavelet wavelet);
/// @param name  one of wavelet_names()
codec::Wavelet wavelet_named(const std::string& name);

/// What an archive holds, for people and for programs.
std::string archive_table(const pipeline::ArchiveSummary& summary,
                          const std::filesystem::path& path);
std::string archive_json(const pipeline::ArchiveSummary& summary,
                         const std::filesystem::path& path);
std::string decoded_text(const pipeline::DecodeSummary& summary,
                         const std::filesystem::path& output);

}  // namespace remaps::cli
