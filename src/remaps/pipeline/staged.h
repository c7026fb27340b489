#pragma once

#include <filesystem>

#include "remaps/store/file.h"

namespace remaps::pipeline {

/// The directory that a file or directory is in, or will be.
inline std::filesystem::path parent_of(const std::filesystem::path& path) {
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return whole.has_filename() ? whole.parent_path() : whole.parent_path().parent_path();
}

inline std::filesystem::path without_slash(const std::filesystem::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

/// A place beside the final one, on the same file system, so that a rename finishes the job.
/// Removed with all that is in it when the object goes.
class Staged {
 public:
  explicit Staged(const std::filesystem::path& target)
      : target_(target), directory_(parent_of(target)) {}

  const std::filesystem::path& target() const { return target_; }
  std::filesystem::path path() const { return directory_.path() / target_.filename(); }
  /// Replaces what is there; only ever called for an earlier bundle.
  void directory_to_target() const {
    const std::filesystem::path old = directory_.path() / "replaced";
    if (std::filesystem::exists(target_)) std::filesystem::rename(target_, old);
    std::filesystem::rename(path(), target_);
  }

 private:
  std::filesystem::path target_;
  store::TempDir directory_;
};

/// A directory that a bundle may replace.
/// @throws IoError  something else is there
void check_bundle_target(const std::filesystem::path& bundle);

}  // namespace remaps::pipeline
