#include "remaps/mesh/attribute_file.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::uint64_t kMostBlockRows = 1 << 14;
constexpr std::uint64_t kMostBlockBytes = 1 << 20;

}  // namespace

std::size_t AttributeLayout::row_bytes(AttributePer per) const {
  const std::size_t bytes = remaps::row_bytes(specs, per);
  return per == AttributePer::corner && bytes > 0 ? 3 * (kCornerVertex + bytes) : bytes;
}

std::uint64_t AttributeLayout::rows(AttributePer per) const {
  if (row_bytes(per) == 0) return 0;
  return per == AttributePer::vertex ? vertices : faces;
}

std::uint64_t AttributeLayout::block_rows(AttributePer per) const {
  std::uint64_t rows = kMostBlockRows;
  while (rows > 1 && rows * row_bytes(per) > kMostBlockBytes) rows /= 2;
  return rows;
}

std::uint64_t AttributeLayout::blocks(AttributePer per) const {
  return rows(per) / block_rows(per) + (rows(per) % block_rows(per) != 0);
}

std::size_t AttributeLayout::first_section(AttributePer per) const {
  std::uint64_t first = 0;
  for (const AttributePer before : {AttributePer::vertex, AttributePer::face}) {
    if (before < per) first += blocks(before);
  }
  return static_cast<std::size_t>(first);
}

std::size_t AttributeLayout::sections() const {
  return first_section(AttributePer::corner) +
         static_cast<std::size_t>(blocks(AttributePer::corner));
}

void AttributeFileWriter::flush() {
  if (!block_.empty()) file_.append(store::pack_section(block_));
  block_.clear();
}

void AttributeFileWriter::add(AttributePer per, std::span<const std::byte> rows) {
  if (per != per_) flush();
  per_ = per;
  const std::size_t bytes = layout_.row_bytes(per);
  const std::size_t block = bytes * static_cast<std::size_t>(layout_.block_rows(per));
  added_[static_cast<std::size_t>(per)] += rows.size() / bytes;
  while (!rows.empty()) {
    const std::size_t part = std::min(rows.size(), block - block_.size());
    block_.insert(block_.end(), rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(part));
    rows = rows.subspan(part);
    if (block_.size() == block) flush();
  }
}

void AttributeFileWriter::seal() {
  flush();
  for (const AttributePer per : {AttributePer::vertex, AttributePer::face, AttributePer::corner}) {
    const std::uint64_t found = added_[static_cast<std::size_t>(per)];
    if (found == layout_.rows(per)) continue;
    throw CorruptionError(std::to_string(found) + " rows of " + std::string(name_of(per)) +
                          " attributes instead of " + std::to_string(layout_.rows(per)));
  }
  file_.seal();
}

AttributeFile::AttributeFile(const std::filesystem::path& path, AttributeLayout layout,
                             const std::filesystem::path& copies)
    : layout_(std::move(layout)), file_(path, kAttributeKind) {
  if (layout_.copies > 0) copies_.emplace(copies, layout_.vertices, layout_.copies);
  const auto refuse = [&](const std::string& why) {
    throw CorruptionError(path.string() + ": " + why);
  };
  if (file_.sections() != layout_.sections()) {
    refuse(std::to_string(file_.sections()) + " blocks, but the manifest's attributes take " +
           std::to_string(layout_.sections()));
  }
  for (const AttributePer per : {AttributePer::vertex, AttributePer::face, AttributePer::corner}) {
    const std::uint64_t most = layout_.block_rows(per);
    for (std::uint64_t b = 0; b < layout_.blocks(per); ++b) {
      const std::uint64_t rows = std::min(most, layout_.rows(per) - b * most);
      const std::size_t section = layout_.first_section(per) + static_cast<std::size_t>(b);
      if (file_.raw_bytes(section) != rows * layout_.row_bytes(per)) {
        refuse("block " + std::to_string(section) + " has another size than its rows");
      }
    }
  }
}

VertexId AttributeFile::original(VertexId vertex) {
  if (vertex < layout_.vertices) return vertex;
  if (copies_) return copies_->original(vertex);
  throw CorruptionError(file_.path().string() + ": there are attributes of " +
                        std::to_string(layout_.vertices) + " vertices, none of vertex " +
                        std::to_string(vertex));
}

void AttributeFile::read(AttributePer per, std::uint64_t first, std::span<std::byte> out) {
  const std::size_t bytes = layout_.row_bytes(per);
  const std::uint64_t block = layout_.block_rows(per);
  while (!out.empty()) {
    if (first >= layout_.rows(per))
      throw CorruptionError("attributes beyond the last were asked for");
    const std::size_t section =
        layout_.first_section(per) + static_cast<std::size_t>(first / block);
    if (section != loaded_) file_.read(section, block_);
    loaded_ = section;
    const std::size_t within = static_cast<std::size_t>(first % block) * bytes;
    const std::size_t part = std::min(out.size(), block_.size() - within);
    std::memcpy(out.data(), block_.data() + within, part);
    out = out.subspan(part);
    first += part / bytes;
  }
}

AttributeColumns::AttributeColumns(AttributeFile& file, AttributePer per,
                                   std::span<const AttributeSpec> chosen)
    : file_(file), per_(per) {
  const auto wanted = [&](const AttributeSpec& spec) {
    return std::find(chosen.begin(), chosen.end(), spec) != chosen.end();
  };
  const std::vector<AttributeSpec> all = attributes_per(file.layout().specs, per);
  if (std::none_of(all.begin(), all.end(), wanted)) return;
  std::size_t at = 0;
  const auto pass = [&](std::size_t bytes, bool take) {
    if (take) pieces_.push_back({at, bytes});
    if (take) row_bytes_ += bytes;
    at += bytes;
  };
  const bool corner = per == AttributePer::corner;
  for (int i = 0; i < (corner ? 3 : 1); ++i) {
    if (corner) pass(AttributeLayout::kCornerVertex, true);
    for (const AttributeSpec& spec : all) pass(remaps::row_bytes(spec), wanted(spec));
  }
}

void AttributeColumns::read(std::uint64_t first, std::span<std::byte> out) {
  const std::size_t whole = file_.layout().row_bytes(per_);
  if (row_bytes_ == whole) {
    file_.read(per_, first, out);
    return;
  }
  const std::uint64_t most = file_.layout().block_rows(per_);
  while (!out.empty()) {
    const auto count = std::min<std::uint64_t>(most - first % most, out.size() / row_bytes_);
    whole_.resize(static_cast<std::size_t>(count) * whole);
    file_.read(per_, first, whole_);
    for (std::uint64_t i = 0; i < count; ++i) {
      for (const Piece& piece : pieces_) {
        std::memcpy(out.data(), whole_.data() + i * whole + piece.offset, piece.bytes);
        out = out.subspan(piece.bytes);
      }
    }
    first += count;
  }
}

}  // namespace remaps
