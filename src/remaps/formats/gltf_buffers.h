#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/formats/gltf_json.h"
#include "remaps/formats/random_source.h"

namespace remaps {

/// The bytes of a buffer, wherever they are: in the BIN chunk of the file, in a file beside it, or
/// as base64 in its JSON.
class GltfBuffer {
 public:
  /// @param text_bytes  of base64; 0: the bytes are there as they are
  GltfBuffer(std::shared_ptr<const RandomSource> source, std::uint64_t begin, std::uint64_t bytes,
             std::uint64_t text_bytes = 0)
      : source_(std::move(source)), begin_(begin), bytes_(bytes), text_bytes_(text_bytes) {}

  /// As announced; not more than there are.
  std::uint64_t bytes() const { return bytes_; }
  /// @param offset  offset + out.size() <= bytes()
  /// @throws InputError  text that is not base64, or the file has changed
  void read(std::uint64_t offset, std::span<char> out) const;
  /// Offset in source() of the first byte, where they are there as they are.
  std::optional<std::uint64_t> plain_begin() const {
    return text_bytes_ == 0 ? std::optional(begin_) : std::nullopt;
  }
  const RandomSource& source() const { return *source_; }

 private:
  void read_base64(std::uint64_t offset, std::span<char> out) const;

  std::shared_ptr<const RandomSource> source_;
  std::uint64_t begin_, bytes_, text_bytes_;
};

/// A glTF file, .glb or .gltf, with the sources of its buffers.
class GltfFile {
 public:
  /// Reads the JSON. Buffers are opened when they are asked for.
  /// @throws InputError
  explicit GltfFile(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return source_->path(); }
  GltfValue root() const { return {json_.root, path()}; }
  /// @throws InputError  missing, too short or not of a kind that is read
  GltfBuffer open_buffer(const GltfValue& buffer);

  /// All files that were opened.
  const std::vector<std::shared_ptr<const RandomSource>>& sources() const { return sources_; }

 private:
  void read_glb();
  GltfBuffer open_data(const GltfValue& uri, const std::string& text, std::uint64_t bytes);
  const DataPayload& payload_of(const GltfValue& uri, std::string_view mark) const;
  GltfBuffer open_beside(const GltfValue& uri, const std::string& text, std::uint64_t bytes);

  std::shared_ptr<const RandomSource> source_;
  std::vector<std::shared_ptr<const RandomSource>> sources_;
  GltfJson json_;
  std::optional<std::uint64_t> bin_begin_;
  std::uint64_t bin_bytes_ = 0;
};

}  // namespace remaps
