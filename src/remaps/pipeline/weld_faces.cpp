#include "remaps/pipeline/weld_faces.h"

#include <optional>
#include <vector>

#include "remaps/base/errors.h"

namespace remaps::pipeline {
namespace {

using Numbers = std::vector<std::uint64_t>;

constexpr std::uint64_t kNumberBytes = sizeof(std::uint64_t);

/// Reads the numbers of a range, all of which it has.
void load(NumberFile& numbers, const VertexRanges& ranges, std::uint64_t range, Numbers& out) {
  out.resize(static_cast<std::size_t>(ranges.length(range)));
  numbers.read(ranges.first(range), out);
}

void renumber_in_memory(IndexedMeshReader& mesh, const Numbers& number, Progress& progress,
                        NumberFile& corners) {
  Numbers chunk;
  mesh.read_triangles([&](std::span<const Triangle> triangles) {
    chunk.clear();
    for (const Triangle& t : triangles) {
      for (const VertexId v : t) chunk.push_back(number[static_cast<std::size_t>(v)]);
    }
    corners.append(chunk);
    progress.advance(mesh.pass_fraction());
  });
}

/// The corners of all faces, by ranges of their vertices.
class WaitingCorners {
 public:
  WaitingCorners(const WeldScratch& scratch, const VertexRanges& ranges)
      : ranges_(ranges),
        file_(scratch.directory / "weld-corners", static_cast<std::size_t>(ranges.count),
              scratch.memory_bytes / 8, *scratch.budget),
        before_(static_cast<std::size_t>(ranges.count), 0) {}

  void add(VertexId v) {
    const std::size_t range = ranges_.of(v);
    std::byte record[kLargestWeldRecord];
    std::byte* end = put_varint(record, size_ - before_[range]);
    file_.append(range, {record, put_varint(end, v - ranges_.first(range))});
    before_[range] = size_++;
  }
  std::uint64_t size() const { return size_; }

  /// Calls corner(number of the corner, its vertex within the range).
  template <class Corner>
  void take(std::uint64_t range, Corner&& corner) {
    std::uint64_t c = 0;
    for_each_weld_record(file_, static_cast<std::size_t>(range), [&](const std::byte* at) {
      std::uint64_t step = 0;
      std::uint64_t v = 0;
      at = get_varint(get_varint(at, step), v);
      c += step;
      corner(c, v);
      return at;
    });
    file_.release(static_cast<std::size_t>(range));
  }

 private:
  VertexRanges ranges_;
  store::BucketFile file_;
  std::vector<std::uint64_t> before_;
  std::uint64_t size_ = 0;
};

/// Brings what comes by ranges of vertices into the order of corners, and writes it.
class CornerOrder {
 public:
  CornerOrder(const WeldScratch& scratch, std::uint64_t corners)
      : ranges_(corners, kNumberBytes, scratch.memory_bytes / 2),
        file_(scratch.directory / "weld-renumbered", static_cast<std::size_t>(ranges_.count),
              scratch.memory_bytes / 8, *scratch.budget) {}

  void add(std::uint64_t corner, std::uint64_t number) {
    const std::size_t range = ranges_.of(corner);
    std::byte record[kLargestWeldRecord];
    std::byte* end = put_varint(record, corner - ranges_.first(range));
    file_.append(range, {record, put_varint(end, number)});
  }

  void write(Numbers& number, Progress& progress, NumberFile& corners) {
    for (std::uint64_t range = 0; range < ranges_.count; ++range) {
      number.assign(static_cast<std::size_t>(ranges_.length(range)), 0);
      for_each_weld_record(file_, static_cast<std::size_t>(range), [&](const std::byte* at) {
        std::uint64_t corner = 0;
        std::uint64_t value = 0;
        at = get_varint(get_varint(at, corner), value);
        if (corner >= number.size()) throw CorruptionError("a corner of welding is out of range");
        number[static_cast<std::size_t>(corner)] = value;
        return at;
      });
      file_.release(static_cast<std::size_t>(range));
      corners.append(number);
      progress.advance(0.7 + 0.3 * double(range + 1) / double(ranges_.count));
    }
  }

 private:
  VertexRanges ranges_;
  store::BucketFile file_;
};

}  // namespace

void renumber_corners(IndexedMeshReader& mesh, NumberFile& numbers, const WeldScratch& scratch,
                      Progress& progress, NumberFile& corners) {
  const std::uint64_t memory = scratch.memory_bytes / 2;
  const VertexRanges ranges(numbers.size(), kNumberBytes, memory);
  const Reservation reservation =
      scratch.budget->reserve(std::max(memory, ranges.size * kNumberBytes), "renumbering faces");
  Numbers number;
  if (ranges.count == 1) {
    load(numbers, ranges, 0, number);
    renumber_in_memory(mesh, number, progress, corners);
    return;
  }
  WaitingCorners waiting(scratch, ranges);
  mesh.read_triangles([&](std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles) {
      for (const VertexId v : t) waiting.add(v);
    }
    progress.advance(0.4 * mesh.pass_fraction());
  });
  CornerOrder order(scratch, waiting.size());
  for (std::uint64_t range = 0; range < ranges.count; ++range) {
    load(numbers, ranges, range, number);
    waiting.take(range, [&](std::uint64_t corner, std::uint64_t v) {
      order.add(corner, number.at(static_cast<std::size_t>(v)));
    });
    progress.advance(0.4 + 0.3 * double(range + 1) / double(ranges.count));
  }
  order.write(number, progress, corners);
}

}  // namespace remaps::pipeline
