#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "remaps/mesh/attributes.h"
#include "remaps/mesh/vertex_copies.h"
#include "remaps/store/section_file.h"

namespace remaps {

inline constexpr std::array<char, 4> kAttributeKind{'a', 't', 't', 'r'};

/// The attributes of a mesh, as rows in the order of the input, blocked and checksummed: first
/// those of vertices, then of faces, then of corners, three of which are one row here. Byte-level
/// format: docs/formats/attributes.md.
struct AttributeLayout {
  /// Before the attributes of a corner stands the input index of its vertex: repair may turn faces.
  static constexpr std::size_t kCornerVertex = sizeof(std::uint64_t);

  std::vector<AttributeSpec> specs;
  std::uint64_t vertices = 0, faces = 0;
  std::uint64_t copies = 0;  ///< vertices that repair made, numbered from `vertices` on

  /// Of a row in the file: of a face's three corners together. 0: there are no such rows.
  std::size_t row_bytes(AttributePer per) const;
  std::uint64_t rows(AttributePer per) const;
  /// Rows of a section: 2^14, or the next lower power of two that takes no more than 1 MiB.
  std::uint64_t block_rows(AttributePer per) const;
  std::uint64_t blocks(AttributePer per) const;
  std::size_t first_section(AttributePer per) const;
  std::size_t sections() const;
};

/// Writes the rows of vertices, faces and corners, in this order.
class AttributeFileWriter {
 public:
  AttributeFileWriter(const std::filesystem::path& path, AttributeLayout layout)
      : layout_(std::move(layout)), file_(path, kAttributeKind) {}

  /// Whole rows of the file; all of one kind, from the first, before the next.
  void add(AttributePer per, std::span<const std::byte> rows);
  /// @throws CorruptionError  rows are missing or too many
  void seal();

 private:
  void flush();

  AttributeLayout layout_;
  store::SectionFileWriter file_;
  AttributePer per_ = AttributePer::vertex;
  std::array<std::uint64_t, 3> added_{};
  store::Bytes block_;
};

/// Reads rows of a sealed file. One thread at a time.
class AttributeFile {
 public:
  /// @param copies  the file of a VertexCopiesWriter, read if the layout has copies
  /// @throws CorruptionError  a file is damaged, or has other sections than the layout asks for
  AttributeFile(const std::filesystem::path& path, AttributeLayout layout,
                const std::filesystem::path& copies = {});

  const AttributeLayout& layout() const { return layout_; }
  const store::SectionFile& sections() const { return file_; }
  /// The vertex whose attributes a vertex has: itself, or what it is a copy of; kNoVertex: none.
  /// @throws CorruptionError  there is no such vertex
  VertexId original(VertexId vertex);
  /// Reads rows first ... first + out.size() / row_bytes(per) - 1.
  void read(AttributePer per, std::uint64_t first, std::span<std::byte> out);

 private:
  AttributeLayout layout_;
  store::SectionFile file_;
  std::optional<VertexCopies> copies_;
  std::size_t loaded_ = ~std::size_t{0};
  store::Bytes block_;
};

/// The columns of some attributes out of the rows of a file.
class AttributeColumns {
 public:
  /// @param chosen  of the file, in its order; those of other elements are passed over
  AttributeColumns(AttributeFile& file, AttributePer per, std::span<const AttributeSpec> chosen);

  /// Bytes of a row of the chosen attributes; of corners three together.
  std::size_t row_bytes() const { return row_bytes_; }
  std::uint64_t rows() const { return file_.layout().rows(per_); }
  /// Reads rows first, first + 1, ...: as many as fit.
  void read(std::uint64_t first, std::span<std::byte> out);

 private:
  struct Piece {
    std::size_t offset, bytes;
  };

  AttributeFile& file_;
  AttributePer per_;
  std::vector<Piece> pieces_;  // of a row of the file
  std::size_t row_bytes_ = 0;
  store::Bytes whole_;
};

}  // namespace remaps
