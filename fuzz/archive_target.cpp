#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "fuzz_targets.h"
#include "remaps/base/errors.h"
#include "remaps/codec/archive.h"
#include "remaps/codec/checked_blocks.h"

namespace remaps::fuzz {
namespace {

/// Where docs/formats/archive.md has what is to be put right.
constexpr std::size_t kHeaderBytes = 68, kSignalBytes = 16, kPointBytes = 8;
constexpr std::size_t kPoints = 15, kBaseBytes = 56, kGeometryBytes = 60, kSignalsBytes = 64;
/// For some ten thousand vertices.
constexpr std::uint64_t kBudgetBytes = 1 << 20;

std::uint64_t load32(const store::Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Puts the checksum behind a part right, as far as it is there.
/// @return  where the next part starts
std::uint64_t seal(store::Bytes& bytes, std::uint64_t at, std::uint64_t size) {
  const std::uint64_t end = at + size + codec::kChecksumBytes;
  if (end <= bytes.size()) {
    const std::uint32_t checksum = codec::checksum32(store::ByteSpan(bytes).subspan(at, size));
    std::memcpy(bytes.data() + at + size, &checksum, sizeof checksum);
  }
  return end;
}

std::uint64_t seal_blocks(store::Bytes& bytes, std::uint64_t at, std::uint64_t code_bytes) {
  while (code_bytes > 0 && at < bytes.size()) {
    const std::uint64_t size = std::min<std::uint64_t>(code_bytes, codec::kBlockBytes);
    at = seal(bytes, at, size);
    code_bytes -= size;
  }
  return at;
}

/// Puts all checksums of an archive right, and cuts it where its header says that it ends.
void seal_archive_file(store::Bytes& bytes) {
  if (bytes.size() < kHeaderBytes + codec::kChecksumBytes) return;
  std::uint64_t at = seal(bytes, 0, kHeaderBytes);
  at = seal(bytes, at, load32(bytes, kBaseBytes));
  at = seal_blocks(bytes, at, load32(bytes, kGeometryBytes));
  const std::uint64_t end = at + load32(bytes, kSignalsBytes);
  while (at < end && at + kSignalBytes <= bytes.size()) {
    const std::uint64_t code_bytes = load32(bytes, at + kSignalBytes - 4);
    at = seal_blocks(bytes, seal(bytes, at, kSignalBytes), code_bytes);
  }
  const auto points = static_cast<std::uint64_t>(bytes[kPoints]);
  if (points > 0) at = seal(bytes, at, points * kPointBytes);
  if (at < bytes.size()) bytes.resize(at);
}

std::optional<codec::SemiRegularMesh> decode(const codec::Archive& archive, std::uint64_t prefix,
                                             unsigned level) {
  try {
    MemoryBudget budget(kBudgetBytes);
    return archive.decode(prefix, level, budget);
  } catch (const CorruptionError&) {
  } catch (const BudgetError&) {
  }
  return std::nullopt;
}

bool is_finite(const std::vector<Vec3>& values) {
  return std::all_of(values.begin(), values.end(), [](const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  });
}

void check_mesh(const codec::SemiRegularMesh& mesh, const codec::ArchiveHeader& header) {
  expect(mesh.base.size() == header.base_faces && mesh.base_vertices == header.base_vertices,
         "the base has the counts of the header");
  MemoryBudget budget(kBudgetBytes);
  const codec::SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  expect(mesh.position.size() == hierarchy.vertices(), "each vertex has a position");
  for (const codec::Signal& signal : mesh.signals) {
    expect(signal.value.size() == hierarchy.vertices(), "each vertex has a value of a signal");
  }
}

std::optional<codec::SemiRegularMesh> code_again(codec::SemiRegularMesh mesh) {
  try {
    MemoryBudget budget(4 * kBudgetBytes);
    const store::Bytes bytes = codec::encode_mesh(std::move(mesh), {}, budget);
    const codec::Archive again(bytes, "again");
    expect(again.complete(), "what is written is complete");
    return again.decode(bytes.size(), again.header().levels, budget);
  } catch (const GeometryError&) {  // out of the range of numbers
  } catch (const BudgetError&) {
  }
  return std::nullopt;
}

bool has_finite_values(const codec::SemiRegularMesh& mesh) {
  return is_finite(mesh.position) &&
         std::all_of(mesh.signals.begin(), mesh.signals.end(),
                     [](const codec::Signal& signal) { return is_finite(signal.value); });
}

/// What was decoded can be coded again, if there are numbers for it. A hostile archive may have its
/// base in another order than a coder gives it; after that the order stays.
void check_again(codec::SemiRegularMesh mesh) {
  if (!has_finite_values(mesh)) return;
  const std::size_t faces = mesh.base.size(), vertices = mesh.position.size();
  const auto ordered = code_again(std::move(mesh));
  if (!ordered || !has_finite_values(*ordered)) return;
  expect(ordered->base.size() == faces && ordered->position.size() == vertices,
         "coding changes no counts");
  const auto again = code_again(*ordered);
  expect(!again || again->base == ordered->base, "a base is coded and decoded the same");
}

void read_archive(store::ByteSpan bytes) {
  try {
    const codec::Archive archive(bytes, "archive");
    const codec::ArchiveHeader& header = archive.header();
    const std::uint64_t least = archive.least_bytes(), all = bytes.size();
    const auto shortest = decode(archive, least, header.levels);
    const auto half = decode(archive, (least + all) / 2, header.levels);
    std::optional<codec::SemiRegularMesh> full = decode(archive, all, header.levels);
    const auto coarse = decode(archive, all, 0);
    if (!full) return;
    expect(shortest && half && coarse, "what can be decoded can be in part");
    expect(shortest->base == full->base && coarse->base == full->base, "all parts have one base");
    for (const auto* mesh : {&shortest, &half, &coarse}) check_mesh(**mesh, header);
    check_mesh(*full, header);
    const codec::Archive cut(bytes.first((least + all) / 2), "cut");
    const auto same = decode(cut, all, header.levels);
    expect(same && (same->position == half->position || !is_finite(half->position)),
           "a file that ends is its prefix");
    check_again(std::move(*full));
  } catch (const InputError&) {
  } catch (const CorruptionError&) {
  }
}

}  // namespace

void fuzz_archive(Input input) {
  read_archive(input);
  store::Bytes bytes(input.begin(), input.end());
  seal_archive_file(bytes);
  read_archive(bytes);
}

}  // namespace remaps::fuzz
