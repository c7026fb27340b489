#include "remaps/pipeline/weld.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/pipeline/weld_attributes.h"
#include "remaps/pipeline/weld_faces.h"
#include "remaps/pipeline/weld_match.h"

namespace remaps::pipeline {
namespace {

constexpr std::uint64_t kUnknown = ~std::uint64_t{0};
constexpr std::size_t kChunk = 8192;

// Where the stages begin, as fractions of the work.
constexpr double kMatch = 0.4, kNumber = 0.6, kFaces = 0.85;

template <class Point>
Point to_point(const Vec3& p) {
  if constexpr (std::is_same_v<Point, Vec3f>) {
    return to_float(p);
  } else {
    return p;
  }
}

/// Numbers the roots in order, and gives all others the number of their root. Range by range: what
/// a range needs of lower ones was sent to it when they were done.
template <class Point>
class Numbering {
 public:
  Numbering(const WeldScratch& scratch, const VertexRanges& ranges, LinkBuckets<Point>& links,
            TemporaryArray& positions, NumberFile& numbers)
      : ranges_(ranges),
        links_(links),
        positions_(positions),
        numbers_(numbers),
        reservation_(scratch.budget->reserve(ranges.size * kBytesPerVertex, "numbering vertices")),
        sent_(scratch.directory / "weld-numbers-sent", static_cast<std::size_t>(ranges.count),
              scratch.memory_bytes / 8, *scratch.budget) {}

  static constexpr std::uint64_t kBytesPerVertex =
      sizeof(std::uint64_t) + sizeof(LocalIndex) + sizeof(Point);

  /// @return  the number of roots
  std::uint64_t run(FunctionRef<void(double)> progress) {
    for (std::uint64_t range = 0; range < ranges_.count; ++range) {
      load(range);
      resolve();
      if (goes_on_) send(range);
      links_.release(range);
      numbers_.append(number_);
      progress(double(range + 1) / double(ranges_.count));
    }
    return next_;
  }

 private:
  void load(std::uint64_t range) {
    const auto n = static_cast<std::size_t>(ranges_.length(range));
    number_.assign(n, kUnknown);
    to_.assign(n, kNoIndex);
    position_.resize(n);
    goes_on_ = false;
    links_.visit(
        range,
        [&](std::uint64_t v, const Point& p) {
          if (v >= n) fail();
          to_[v] = static_cast<LocalIndex>(v);
          position_[v] = p;
        },
        [&](std::uint64_t v, std::uint64_t to) {
          if (v < n) to_[v] = static_cast<LocalIndex>(to);
          goes_on_ = goes_on_ || v >= n;
        });
    for_each_weld_record(sent_, static_cast<std::size_t>(range), [&](const std::byte* at) {
      std::uint64_t v = 0;
      std::uint64_t number = 0;
      at = get_varint(get_varint(at, v), number);
      if (v >= n) fail();
      number_[v] = number;
      return at;
    });
    sent_.release(static_cast<std::size_t>(range));
  }

  void resolve() {
    std::size_t roots = 0;
    for (std::size_t v = 0; v < number_.size(); ++v) {
      if (to_[v] == v) {
        number_[v] = next_++;
        position_[roots++] = position_[v];
      } else if (number_[v] == kUnknown) {
        if (to_[v] >= v) fail();
        number_[v] = number_[to_[v]];
      }
    }
    positions_.append(std::span<const Point>(position_).first(roots));
  }

  void send(std::uint64_t range) {
    const std::uint64_t first = ranges_.first(range);
    links_.visit(
        range, [](std::uint64_t, const Point&) {},
        [&](std::uint64_t v, std::uint64_t to) {
          if (v < number_.size()) return;
          std::byte record[kLargestWeldRecord];
          const std::size_t later = ranges_.of(first + v);
          std::byte* end = put_varint(record, first + v - ranges_.first(later));
          sent_.append(later, {record, put_varint(end, number_[to])});
        });
  }

  [[noreturn]] static void fail() {
    throw CorruptionError("links of welding do not lead to a first vertex");
  }

  VertexRanges ranges_;
  LinkBuckets<Point>& links_;
  TemporaryArray& positions_;
  NumberFile& numbers_;
  Reservation reservation_;
  store::BucketFile sent_;
  std::vector<std::uint64_t> number_;  // of the vertices of a range
  std::vector<LocalIndex> to_;         // where they go in the range; themselves if roots
  std::vector<Point> position_;
  bool goes_on_ = false;  // to later ranges
  std::uint64_t next_ = 0;
};

/// Cuts the polygons of a mesh whose vertices have new numbers.
template <class Point>
class WeldedPolygons final : public PolygonCutter {
 public:
  WeldedPolygons(IndexedMeshReader& mesh, NumberFile& numbers, const TemporaryArray& positions)
      : mesh_(mesh), numbers_(numbers), positions_(positions) {
    mesh_.set_polygon_cutter(this);
  }
  ~WeldedPolygons() override { mesh_.set_polygon_cutter(nullptr); }
  WeldedPolygons(const WeldedPolygons&) = delete;
  WeldedPolygons& operator=(const WeldedPolygons&) = delete;

 private:
  Vec3 position(VertexId v) override {
    std::uint64_t number = 0;
    numbers_.read(v, std::span(&number, 1));
    Point p;
    positions_.read(number, std::span(&p, 1));
    return {p.x, p.y, p.z};
  }

  IndexedMeshReader& mesh_;
  NumberFile& numbers_;
  const TemporaryArray& positions_;
};

template <class Point>
class WeldedFiles final : public WeldedMesh {
 public:
  explicit WeldedFiles(const std::filesystem::path& directory)
      : positions_(directory / "welded-vertices", sizeof(Point)) {}

  void build(IndexedMeshReader& mesh, const WeldOptions& options, MemoryBudget& budget,
             Progress& progress) {
    const WeldScratch scratch{options.directory, options.memory_bytes, &budget};
    if (options.distance > 0) {
      NearMatcher<Point> matcher(scratch, options.distance);
      weld(mesh, matcher, scratch, progress);
    } else {
      EqualMatcher<Point> matcher(scratch);
      weld(mesh, matcher, scratch, progress);
    }
    bytes_total_ = mesh.bytes_total();
    bytes_read_total_ = mesh.bytes_read_total();
  }

  void read_positions(PositionSink sink) override {
    std::vector<Point> stored(kChunk);
    std::vector<Vec3> chunk(kChunk);
    for (std::uint64_t first = 0; first < positions_.size(); first += kChunk) {
      const auto n =
          static_cast<std::size_t>(std::min<std::uint64_t>(kChunk, positions_.size() - first));
      positions_.read(first, std::span(stored).first(n));
      std::transform(stored.begin(), stored.begin() + static_cast<std::ptrdiff_t>(n), chunk.begin(),
                     [](const Point& p) {
                       return Vec3{p.x, p.y, p.z};
                     });
      fraction_ = double(first + n) / double(positions_.size());
      sink(std::span<const Vec3>(chunk).first(n));
    }
  }

  void read_triangles(IndexSink sink) override {
    std::vector<std::uint64_t> corner(3 * kChunk);
    std::vector<Triangle> chunk(kChunk);
    const std::uint64_t faces = corners_->size() / 3;
    for (std::uint64_t first = 0; first < faces; first += kChunk) {
      const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(kChunk, faces - first));
      corners_->read(3 * first, std::span(corner).first(3 * n));
      for (std::size_t i = 0; i < n; ++i)
        chunk[i] = {corner[3 * i], corner[3 * i + 1], corner[3 * i + 2]};
      fraction_ = double(first + n) / double(faces);
      sink(std::span<const Triangle>(chunk).first(n));
    }
  }

  bool positions_are_float() const override { return std::is_same_v<Point, Vec3f>; }
  std::optional<PositionArray> position_array() const override {
    if (!std::is_same_v<Point, Vec3f>) return std::nullopt;
    return PositionArray{positions_.path(), 0};
  }
  void carry_attributes(std::unique_ptr<IndexedMeshReader> source) override {
    // Faces that shared no vertices have no attributes to carry.
    if (!numbers_) return;
    source_ = std::move(source);
    attributes_.emplace(*source_, *numbers_, *corners_);
  }
  std::vector<AttributeSpec> attributes() override {
    return attributes_ ? attributes_->attributes() : std::vector<AttributeSpec>{};
  }
  void read_attributes(AttributePer per, AttributeSink sink) override {
    with_source([&] { attributes_->read_attributes(per, followed(sink)); });
  }
  void read_pool(std::size_t number, AttributeSink sink) override {
    with_source([&] { attributes_->read_pool(number, followed(sink)); });
  }
  void read_pool_uses(std::size_t number, PoolUseSink sink) override {
    with_source([&] { attributes_->read_pool_uses(number, followed(sink)); });
  }

  double pass_fraction() const override { return fraction_; }
  std::uint64_t bytes_total() const override { return bytes_total_; }
  std::uint64_t bytes_read() const override {
    return static_cast<std::uint64_t>(fraction_ * double(bytes_total_));
  }
  std::uint64_t bytes_read_total() const override {
    return source_ ? source_->bytes_read_total() : bytes_read_total_;
  }
  std::uint64_t welded_vertices() const override { return vertices_ - positions_.size(); }

 private:
  /// Polygons are cut as they were when the corners were numbered.
  template <class Pass>
  void with_source(Pass pass) {
    if (!attributes_) return;
    const WeldedPolygons<Point> polygons(*source_, *numbers_, positions_);
    pass();
  }
  /// Passes chunks on, and notes how far the source is.
  template <class Sink>
  auto followed(Sink sink) {
    return [this, sink](const auto& chunk) {
      fraction_ = source_->pass_fraction();
      sink(chunk);
    };
  }

  template <class Matcher>
  void weld(IndexedMeshReader& mesh, Matcher& matcher, const WeldScratch& scratch,
            Progress& progress) {
    mesh.read_positions([&](std::span<const Vec3> chunk) {
      for (const Vec3& p : chunk) matcher.add(vertices_++, to_point<Point>(p));
      progress.advance(kMatch * mesh.pass_fraction());
    });
    numbers_ = std::make_unique<NumberFile>(scratch.directory / "weld-numbers", vertices_);
    number(matcher, *numbers_, scratch, progress);
    if (mesh.vertex_sharing() == VertexSharing::none) {
      corners_ = std::move(numbers_);
      return;
    }
    const ProgressPart part(&progress, kFaces, 1);
    corners_ = std::make_unique<NumberFile>(scratch.directory / "welded-corners", vertices_);
    const WeldedPolygons<Point> polygons(mesh, *numbers_, positions_);
    renumber_corners(mesh, *numbers_, scratch, progress, *corners_);
  }

  template <class Matcher>
  void number(Matcher& matcher, NumberFile& numbers, const WeldScratch& scratch,
              Progress& progress) {
    const VertexRanges ranges(vertices_, Numbering<Point>::kBytesPerVertex,
                              scratch.memory_bytes / 2);
    LinkBuckets<Point> links(scratch.directory / "weld-links", ranges, scratch.memory_bytes / 8,
                             *scratch.budget);
    matcher.match(
        links, [&](double fraction) { progress.advance(kMatch + (kNumber - kMatch) * fraction); });
    Numbering<Point>(scratch, ranges, links, positions_, numbers).run([&](double fraction) {
      progress.advance(kNumber + (kFaces - kNumber) * fraction);
    });
  }

  TemporaryArray positions_;
  std::unique_ptr<NumberFile> numbers_;  // of the vertices before; none if they are the corners
  std::unique_ptr<NumberFile> corners_;  // three a face
  std::unique_ptr<IndexedMeshReader> source_;
  std::optional<WeldedAttributes> attributes_;
  std::uint64_t vertices_ = 0;  // before welding
  double fraction_ = 0;
  std::uint64_t bytes_total_ = 0;
  std::uint64_t bytes_read_total_ = 0;
};

template <class Point>
std::unique_ptr<WeldedMesh> weld_as(IndexedMeshReader& mesh, const WeldOptions& options,
                                    MemoryBudget& budget, Progress& progress) {
  auto welded = std::make_unique<WeldedFiles<Point>>(options.directory);
  welded->build(mesh, options, budget, progress);
  return welded;
}

}  // namespace

std::unique_ptr<WeldedMesh> weld_vertices(IndexedMeshReader& mesh, const WeldOptions& options,
                                          MemoryBudget& budget, Progress& progress) {
  return mesh.positions_are_float() ? weld_as<Vec3f>(mesh, options, budget, progress)
                                    : weld_as<Vec3>(mesh, options, budget, progress);
}

}  // namespace remaps::pipeline
