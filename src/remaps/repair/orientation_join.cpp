#include "remaps/repair/orientation_join.h"

#include <algorithm>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps::repair {
namespace {

constexpr std::uint64_t kBytesPerPart = 20 + 1;
constexpr std::uint64_t kPartsAtATime = 1 << 16;
constexpr std::uint64_t kFacesPerBucket = 1 << 22;

}  // namespace

OrientationJoin::OrientationJoin(const std::filesystem::path& path, std::uint64_t faces,
                                 std::uint64_t buffer_bytes, MemoryBudget& budget)
    : budget_(budget),
      file_(path, static_cast<std::size_t>(faces / kFacesPerBucket + 1), buffer_bytes, budget) {}

std::uint32_t OrientationJoin::add(std::span<const OrientedPart> parts,
                                   std::span<const SharedFace> shared) {
  const std::uint64_t first = parts_.size();
  if (first + parts.size() >= std::uint64_t{1} << 31)
    throw GeometryError("the surface is in 2^31 pieces and more");
  while (reserved_parts_ < first + parts.size()) {
    // As much again, since vectors double.
    const std::uint64_t more = std::max(kPartsAtATime, reserved_parts_);
    reservations_.push_back(budget_.reserve(more * kBytesPerPart, "the list of loose pieces"));
    reserved_parts_ += more;
    parts_.reserve(reserved_parts_);
  }
  parts_.insert(parts_.end(), parts.begin(), parts.end());
  forest_.grow(parts_.size());
  for (const SharedFace& face : shared) {
    const std::size_t bucket = (face.face * 0x9E3779B97F4A7C15u >> 32) % file_.buckets();
    file_.append_record(bucket, [&](store::Packer& packer) {
      packer.put40(face.face);
      packer.put(static_cast<std::uint32_t>(first + face.part) << 1 |
                 static_cast<std::uint32_t>(face.turned));
    });
  }
  return static_cast<std::uint32_t>(first);
}

std::optional<FaceId> OrientationJoin::finish() {
  std::optional<FaceId> one_sided;
  store::Bytes bytes;
  std::vector<std::pair<FaceId, std::uint32_t>> seen;
  for (std::size_t bucket = 0; bucket < file_.buckets(); ++bucket) {
    file_.take(bucket, bytes);
    seen.clear();
    store::Unpacker unpacker(bytes, "shared faces");
    while (!unpacker.done()) {
      const FaceId face = unpacker.get40();
      seen.emplace_back(face, unpacker.get<std::uint32_t>());
    }
    std::sort(seen.begin(), seen.end());
    for (std::size_t i = 1; i < seen.size(); ++i) {
      const auto& [face, code] = seen[i];
      const auto& [before, code_before] = seen[i - 1];
      if (face != before) continue;
      const bool turned = ((code ^ code_before) & 1) != 0;
      if (!forest_.unite(code >> 1, code_before >> 1, turned) && !one_sided) one_sided = face;
    }
  }
  for (std::uint32_t part = 0; part < parts_.size(); ++part) {
    const ParityForest::Place place = forest_.find(part);
    if (place.root == part) continue;
    OrientedPart& all = parts_[place.root];
    const OrientedPart& own = parts_[part];
    all.straight += place.turned ? own.turned : own.straight;
    all.turned += place.turned ? own.straight : own.turned;
  }
  turn_.resize(parts_.size());
  for (std::uint32_t part = 0; part < parts_.size(); ++part) {
    const ParityForest::Place place = forest_.find(part);  // its root comes before it
    parts_[part] = parts_[place.root];
    turn_[part] = (parts_[part].turned > parts_[part].straight) != place.turned;
  }
  return one_sided;
}

std::uint64_t OrientationJoin::components_below(std::uint64_t faces) {
  std::uint64_t count = 0;
  for (std::uint32_t part = 0; part < parts_.size(); ++part)
    count += forest_.find(part).root == part && component_faces(part) < faces;
  return count;
}

}  // namespace remaps::repair
