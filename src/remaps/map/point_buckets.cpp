#include "remaps/map/point_buckets.h"

namespace remaps::map {

void PointBuckets::add(std::size_t segment, const TaggedPoint& point) {
  file_.append_record(segment, [&](store::Packer& packer) {
    packer.put40(point.tag);
    packer.put(point.at.face);
    packer.put(point.at.u);
    packer.put(point.at.v);
  });
}

void PointBuckets::read(std::size_t segment, std::uint64_t first, std::uint64_t n,
                        std::vector<TaggedPoint>& out) const {
  thread_local store::Bytes bytes;
  file_.read(segment, first * kRecordBytes, n * kRecordBytes, bytes);
  out.resize(static_cast<std::size_t>(n));
  store::Unpacker unpacker(bytes, "surface points");
  for (TaggedPoint& point : out) {
    point.tag = unpacker.get40();
    point.at.face = unpacker.get<LocalIndex>();
    point.at.u = unpacker.get<double>();
    point.at.v = unpacker.get<double>();
  }
}

}  // namespace remaps::map
