#pragma once

#include <cstdint>
#include <filesystem>

namespace remaps::pipeline {

/// Temporary disk that a run on `input` takes at most, by the size of the file, or of what it
/// holds if compressed: text takes more bytes than its binary form, so this errs on the safe side
/// there.
/// @return  0 when there is no such file: its reader will say so
std::uint64_t temporary_bytes_needed(const std::filesystem::path& input);

/// Refuses a run that would fill the disk.
/// @param directory  where temporary files go
/// @throws BudgetError  names need, free space, directory and option
void check_disk_space(std::uint64_t needed_bytes, const std::filesystem::path& directory);

}  // namespace remaps::pipeline
