#include "remaps/mesh/vertex_copies.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::uint64_t kBlock = 1 << 14;

}  // namespace

void VertexCopiesWriter::flush() {
  if (!block_.empty()) file_.append(store::pack_section(std::as_bytes(std::span(block_))));
  block_.clear();
}

void VertexCopiesWriter::add(std::span<const VertexId> originals) {
  for (const VertexId original : originals) {
    block_.push_back(original);
    if (block_.size() == kBlock) flush();
  }
}

void VertexCopiesWriter::seal() {
  flush();
  file_.seal();
}

VertexCopies::VertexCopies(const std::filesystem::path& path, std::uint64_t vertices,
                           std::uint64_t copies)
    : file_(path, kCopiesKind), vertices_(vertices), copies_(copies) {
  std::uint64_t found = 0;
  for (std::size_t i = 0; i < file_.sections(); ++i) {
    const std::uint64_t expected = std::min(kBlock, copies - std::min(copies, i * kBlock));
    if (file_.raw_bytes(i) != expected * sizeof(VertexId) || expected == 0) break;
    found += expected;
  }
  if (found != copies || file_.sections() != (copies + kBlock - 1) / kBlock) {
    throw CorruptionError(path.string() + ": not the " + std::to_string(copies) +
                          " copies of vertices that the manifest tells of");
  }
}

VertexId VertexCopies::original(VertexId vertex) {
  if (vertex < vertices_) return vertex;
  const std::uint64_t copy = vertex - vertices_;
  const auto refuse = [&](const std::string& why) {
    throw CorruptionError(file_.path().string() + ": vertex " + std::to_string(vertex) + why);
  };
  if (copy >= copies_) refuse(" is beyond the last copy");
  const auto section = static_cast<std::size_t>(copy / kBlock);
  if (section != loaded_) file_.read(section, block_);
  loaded_ = section;
  VertexId original = 0;
  std::memcpy(&original, block_.data() + copy % kBlock * sizeof original, sizeof original);
  if (original != kNoVertex && original >= vertices_) refuse(" is a copy of none of the input's");
  return original;
}

}  // namespace remaps
