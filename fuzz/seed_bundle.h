#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz_targets.h"
#include "remaps/store/packing.h"
#include "remaps/store/section_file.h"

namespace remaps::fuzz {

/// The parts of a bundle that fuzz_bundle replaces, in the order of its first byte. Sections are
/// replaced unpacked.
enum class BundlePart : std::uint8_t {
  manifest,
  base,
  map,
  first_records,  // of segment 0 of the first level
  first_survivors,
  tile,
  last_records,  // of the last level
  last_survivors,
};
inline constexpr std::size_t kBundleParts = 8;

/// A small bundle with several levels and segments, made once in the scratch directory.
class SeedBundle {
 public:
  SeedBundle();

  const std::filesystem::path& directory() const { return directory_; }
  /// The part as the library wrote it.
  store::Bytes part(BundlePart part) const;
  /// Writes the bundle with one part replaced, and every checksum that covers it put right.
  void write_with(BundlePart part, Input content) const;
  /// Puts things back as they were.
  void restore(BundlePart part) const;

 private:
  /// A section file, and which section of it a part is.
  struct Place {
    std::filesystem::path path;
    std::array<char, 4> kind;
    std::size_t section;
  };

  Place place_of(BundlePart part) const;
  std::filesystem::path file_of(BundlePart part) const;
  void write_manifest(std::string text, BundlePart changed) const;

  std::filesystem::path directory_;
  std::string manifest_;
  std::size_t levels_ = 0;
};

}  // namespace remaps::fuzz
