#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "remaps/store/file.h"
#include "remaps/store/packing.h"

namespace remaps::store {

/// A section as it will lie in the file: compressed and checksummed. Made on any thread, appended
/// on one.
struct PackedSection {
  Bytes stored;
  std::uint64_t raw_bytes = 0;
  std::uint64_t checksum = 0;  ///< XXH3-64 of the stored bytes
};
PackedSection pack_section(ByteSpan raw);

/// A sealed container of numbered sections, each compressed and checksummed: logs and tiles.
/// Byte-level format in docs/formats/sections.md.
class SectionFileWriter {
 public:
  /// @param kind  four characters that say what the sections hold
  SectionFileWriter(const std::filesystem::path& path, std::array<char, 4> kind);
  ~SectionFileWriter();
  SectionFileWriter(const SectionFileWriter&) = delete;
  SectionFileWriter& operator=(const SectionFileWriter&) = delete;

  /// @return  number of the section
  std::size_t append(const PackedSection& section);
  /// Writes the index and renames the file to its final name. Without it the file goes with the
  /// object.
  void seal();

 private:
  struct Entry {
    std::uint64_t offset, stored_bytes, raw_bytes, checksum;
  };

  std::filesystem::path path_;
  std::filesystem::path partial_;
  File file_;
  std::uint64_t end_ = 0;
  std::vector<Entry> index_;
  bool sealed_ = false;
};

/// Reads sections of a sealed file; safe on several threads at once.
class SectionFile {
 public:
  /// Checks header, trailer and index.
  /// @throws CorruptionError  not such a file, another kind or version, or damaged
  SectionFile(const std::filesystem::path& path, std::array<char, 4> kind);

  std::size_t sections() const { return index_.size(); }
  std::uint64_t raw_bytes(std::size_t section) const { return index_[section].raw_bytes; }
  const std::filesystem::path& path() const { return file_.path(); }

  /// @param out  resized to the section's raw bytes
  /// @throws CorruptionError  the section fails its checksum or does not unpack
  void read(std::size_t section, Bytes& out) const;

 private:
  struct Entry {
    std::uint64_t offset, stored_bytes, raw_bytes, checksum;
  };

  File file_;
  std::vector<Entry> index_;
};

}  // namespace remaps::store
