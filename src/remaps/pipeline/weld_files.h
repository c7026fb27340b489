#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/base/geometry.h"
#include "remaps/mesh/delta_code.h"
#include "remaps/store/bucket_file.h"
#include "remaps/store/bucket_records.h"
#include "remaps/store/disk_usage.h"
#include "remaps/store/file.h"

/// The temporary files of welding: docs/design/weld.md. Point is Vec3f, or Vec3 where the input is
/// not of floats.
namespace remaps::pipeline {

inline constexpr std::size_t kLargestWeldRecord = 64;

template <class Decode>
void for_each_weld_record(const store::BucketFile& file, std::size_t bucket, Decode&& decode) {
  store::for_each_record(file, bucket, kLargestWeldRecord, "records of welding", decode);
}

template <class Point>
std::byte* put_point(std::byte* at, const Point& p) {
  std::memcpy(at, &p, sizeof p);
  return at + sizeof p;
}
template <class Point>
const std::byte* get_point(const std::byte* at, Point& p) {
  std::memcpy(&p, at, sizeof p);
  return at + sizeof p;
}

/// Three words to 64 well-mixed bits.
inline std::uint64_t hash_words(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  std::uint64_t h = a * 0x9E3779B97F4A7C15u;
  h = ((h ^ h >> 32) + b) * 0xC2B2AE3D27D4EB4Fu;
  h = ((h ^ h >> 29) + c) * 0x165667B19E3779F9u;
  return h ^ h >> 32;
}
inline std::uint64_t hash_of(const Vec3& p) {
  return hash_words(std::bit_cast<std::uint64_t>(p.x), std::bit_cast<std::uint64_t>(p.y),
                    std::bit_cast<std::uint64_t>(p.z));
}
inline std::uint64_t hash_of(const Vec3f& p) {
  return hash_words(std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                    std::bit_cast<std::uint32_t>(p.z));
}

/// Vertices cut into ranges of numbers, each small enough for memory.
struct VertexRanges {
  std::uint64_t vertices = 0;
  std::uint64_t count = 1;
  std::uint64_t size = 1;

  VertexRanges(std::uint64_t n, std::uint64_t bytes_per_vertex, std::uint64_t memory_bytes)
      : vertices(n) {
    // Local numbers of 32 bits.
    const std::uint64_t most =
        std::clamp<std::uint64_t>(memory_bytes / bytes_per_vertex, 1024, std::uint64_t{1} << 31);
    count = std::max<std::uint64_t>((n + most - 1) / most, 1);
    size = std::max<std::uint64_t>((n + count - 1) / count, 1);
  }
  std::size_t of(VertexId v) const { return static_cast<std::size_t>(v / size); }
  std::uint64_t first(std::uint64_t range) const { return range * size; }
  std::uint64_t length(std::uint64_t range) const {
    return std::min(size, vertices - std::min(first(range), vertices));
  }
};

/// For each vertex, where it goes: itself (a root, with its position) or the lower vertex that it
/// is joined to. In buckets by ranges of where it goes.
template <class Point>
class LinkBuckets {
 public:
  LinkBuckets(const std::filesystem::path& path, const VertexRanges& ranges,
              std::uint64_t buffer_bytes, MemoryBudget& budget)
      : ranges_(ranges),
        file_(path, static_cast<std::size_t>(ranges.count), buffer_bytes, budget) {}

  void add_root(VertexId v, const Point& p) {
    std::byte record[kLargestWeldRecord];
    const std::size_t range = ranges_.of(v);
    std::byte* end = put_varint(record, (v - ranges_.first(range)) << 1 | 1);
    file_.append(range, {record, put_point(end, p)});
  }
  /// @param to  below v
  void add_link(VertexId v, VertexId to) {
    std::byte record[kLargestWeldRecord];
    const std::size_t range = ranges_.of(to);
    std::byte* end = put_varint(record, (to - ranges_.first(range)) << 1);
    file_.append(range, {record, put_varint(end, v - to)});
  }

  /// Calls root(v, position) and link(v, to) for what went to a range; all numbers count from the
  /// range's first vertex.
  template <class Root, class Link>
  void visit(std::uint64_t range, Root&& root, Link&& link) const {
    for_each_weld_record(file_, static_cast<std::size_t>(range), [&](const std::byte* at) {
      std::uint64_t code = 0;
      at = get_varint(at, code);
      if (code >> 1 >= ranges_.size) throw CorruptionError("a link of welding is out of range");
      if ((code & 1) != 0) {
        Point p;
        at = get_point(at, p);
        root(code >> 1, p);
      } else {
        std::uint64_t step = 0;
        at = get_varint(at, step);
        link((code >> 1) + step, code >> 1);
      }
      return at;
    });
  }
  void release(std::uint64_t range) { file_.release(static_cast<std::size_t>(range)); }

 private:
  VertexRanges ranges_;
  store::BucketFile file_;
};

/// A growing array in a temporary file, which is removed with the object.
class TemporaryArray {
 public:
  TemporaryArray(std::filesystem::path path, std::size_t element_bytes)
      : path_(std::move(path)), file_(store::File::create(path_)), element_(element_bytes) {}
  ~TemporaryArray() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryArray(const TemporaryArray&) = delete;
  TemporaryArray& operator=(const TemporaryArray&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  template <class T>
  void append(std::span<const T> elements) {
    file_.write_at(size_ * element_, std::as_bytes(elements));
    disk_.grow(elements.size_bytes());
    size_ += elements.size();
  }
  template <class T>
  void read(std::uint64_t first, std::span<T> out) const {
    file_.read_at(first * element_, std::as_writable_bytes(out));
  }

 private:
  std::filesystem::path path_;
  store::File file_;
  std::size_t element_;
  std::uint64_t size_ = 0;
  store::DiskShare disk_;
};

/// Vertex numbers in a temporary file, in 4 bytes each where they fit.
class NumberFile {
 public:
  /// @param below  above all numbers
  NumberFile(const std::filesystem::path& path, std::uint64_t below)
      : narrow_(below <= std::uint64_t{1} << 32), array_(path, narrow_ ? 4 : 8) {}

  std::uint64_t size() const { return array_.size(); }
  void append(std::span<const std::uint64_t> numbers) {
    if (!narrow_) return array_.append(numbers);
    for (std::size_t at = 0; at < numbers.size(); at += kPiece) {
      const auto part = numbers.subspan(at, std::min(kPiece, numbers.size() - at));
      four_.resize(part.size());
      std::transform(part.begin(), part.end(), four_.begin(),
                     [](std::uint64_t n) { return static_cast<std::uint32_t>(n); });
      array_.append(std::span<const std::uint32_t>(four_));
    }
  }
  void read(std::uint64_t first, std::span<std::uint64_t> out) {
    if (!narrow_) return array_.read(first, out);
    for (std::size_t at = 0; at < out.size(); at += kPiece) {
      const auto part = out.subspan(at, std::min(kPiece, out.size() - at));
      four_.resize(part.size());
      array_.read(first + at, std::span(four_));
      std::copy(four_.begin(), four_.end(), part.begin());
    }
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 14;

  bool narrow_;
  TemporaryArray array_;
  std::vector<std::uint32_t> four_;
};

}  // namespace remaps::pipeline
