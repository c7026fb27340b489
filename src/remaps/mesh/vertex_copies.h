#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/store/section_file.h"

namespace remaps {

inline constexpr std::array<char, 4> kCopiesKind{'c', 'o', 'p', 'y'};
/// A vertex that repair made of nothing: it is a copy of none.
inline constexpr VertexId kNoVertex = ~VertexId{0};

/// Writes which input vertex each vertex that repair made is a copy of, in the order of their
/// numbers, which begin behind those of the input. Format: docs/formats/attributes.md.
class VertexCopiesWriter {
 public:
  explicit VertexCopiesWriter(const std::filesystem::path& path) : file_(path, kCopiesKind) {}

  void add(std::span<const VertexId> originals);
  void seal();

 private:
  void flush();

  store::SectionFileWriter file_;
  std::vector<VertexId> block_;
};

/// Looks these up. Holds one block; one thread at a time.
class VertexCopies {
 public:
  /// @param vertices  of the input
  /// @param copies    behind them
  /// @throws CorruptionError  the file is damaged or has another number
  VertexCopies(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t copies);

  /// The input vertex that a vertex is, or is a copy of; kNoVertex if there is none.
  /// @throws CorruptionError  there is no such vertex, or it is a copy of one that is not there
  VertexId original(VertexId vertex);

 private:
  store::SectionFile file_;
  std::uint64_t vertices_, copies_;
  std::size_t loaded_ = ~std::size_t{0};
  store::Bytes block_;
};

}  // namespace remaps
