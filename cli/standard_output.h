#pragma once

#include <string_view>

namespace remaps::cli {

/// Writes data to standard output.
/// @throws IoError  it could not be written; data that does not arrive must not end in exit code 0
void print(std::string_view text);

/// Sends on what is still buffered.
/// @throws IoError  as print
void flush_output();

/// Writes a line to standard error, "remaps: " before it.
void log_line(std::string_view text);

}  // namespace remaps::cli
