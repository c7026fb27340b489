#pragma once

#include <filesystem>
#include <string>

namespace remaps {

/// The extension with its dot, ASCII letters in lower case.
inline std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

/// The same of what a compressed file holds: of x.ply.gz it is .ply.
inline std::string content_extension(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  const bool compressed = extension == ".gz" || extension == ".zst" || extension == ".zstd";
  return compressed ? lower_extension(path.stem()) : extension;
}

}  // namespace remaps
