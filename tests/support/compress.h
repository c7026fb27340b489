#pragma once

#include <string>
#include <string_view>

namespace remaps::test {

/// A gzip file of one member.
std::string gzip(std::string_view content);
/// A Zstandard file of one frame. `announce_size` puts the size of the content into its header.
/// @param window_log  0: the library's choice
std::string zstd(std::string_view content, bool announce_size = true, int window_log = 0);

}  // namespace remaps::test
