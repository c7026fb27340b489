#include "remaps/mesh/closest_point_tree.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/mesh/point_triangle.h"

namespace remaps {
namespace {

// A search radius grows by these, in coordinates scaled to [-1, 1]. Rounding moves a query point q
// by at most sqrt(3) 2^-24 |q| and a box by sqrt(3) 2^-24; Embree's box distance is off by a few
// 2^-24 of itself.
constexpr double kAbsoluteMargin = 0x1p-22;
constexpr double kRelativeMargin = 0x1p-20;

/// Query points further out than this, in scaled coordinates, could overflow Embree's squares.
constexpr double kFar = 0x1p50;

#if defined(__SANITIZE_THREAD__)
constexpr bool kParallelBuild =
    false;  // TBB is not instrumented: its hand-over would look like a race
#else
constexpr bool kParallelBuild = true;
#endif

struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct GeometryRelease {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, DeviceRelease>;
using Scene = std::unique_ptr<RTCSceneTy, SceneRelease>;
using Geometry = std::unique_ptr<RTCGeometryTy, GeometryRelease>;

void check_device(RTCDevice device) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  if (code == RTC_ERROR_OUT_OF_MEMORY) throw Error("Embree: out of memory");
  throw Error("Embree: error " + std::to_string(static_cast<int>(code)));
}

/// Keeps count of what Embree allocates.
class MemoryMeter {
 public:
  static bool count(void* meter, ssize_t bytes, bool /*post*/) {
    static_cast<MemoryMeter*>(meter)->add(bytes);
    return true;
  }
  std::int64_t peak() const { return peak_.load(); }

 private:
  void add(std::int64_t bytes) {
    const std::int64_t now = present_.fetch_add(bytes) + bytes;
    std::int64_t peak = peak_.load();
    while (now > peak && !peak_.compare_exchange_weak(peak, now)) {
    }
  }

  std::atomic<std::int64_t> present_ = 0;
  std::atomic<std::int64_t> peak_ = 0;
};

}  // namespace

class ClosestPointTree::Impl {
 public:
  Impl(std::vector<TrianglePositions> triangles, unsigned threads);

  ClosestPoint closest(const Vec3& p, double bound2, LocalIndex hint) const;

  std::vector<TrianglePositions> triangles;
  Box3 box;
  std::size_t peak_bytes = 0;

 private:
  struct Query;

  Vec3 scaled(const Vec3& p) const { return scale_ * (p - centre_); }
  void fit_scale();
  void build(unsigned threads);
  static void bound(const RTCBoundsFunctionArguments* arguments);
  static bool visit(RTCPointQueryFunctionArguments* arguments);

  Vec3 centre_;
  double scale_ = 1;
  MemoryMeter meter_;  // outlives the device, which reports to it to its end
  Device device_;
  Scene scene_;
};

/// One search under way.
struct ClosestPointTree::Impl::Query {
  const Impl& tree;
  Vec3 p;
  double margin;
  ClosestPoint best;

  /// Takes the triangle if it is closer, or as close and of a lower index. The bound counts as an
  /// answer without a triangle, whose index is the highest.
  bool consider(LocalIndex triangle) {
    const TrianglePoint found = closest_point_on_triangle(p, tree.triangles[triangle]);
    const bool better = found.distance2 < best.distance2 ||
                        (found.distance2 == best.distance2 && triangle < best.triangle);
    if (better) best = {triangle, found.distance2, found.weights};
    return better;
  }

  float radius() const {
    const double exact = tree.scale_ * std::sqrt(best.distance2);
    return static_cast<float>(exact * (1 + kRelativeMargin) + margin);
  }
};

ClosestPointTree::Impl::Impl(std::vector<TrianglePositions> soup, unsigned threads)
    : triangles(std::move(soup)) {
  narrow<LocalIndex>(triangles.size() + 1);  // kNoIndex stays free
  for (const TrianglePositions& triangle : triangles) {
    for (const Vec3& corner : triangle) {
      if (!std::isfinite(corner.x + corner.y + corner.z)) {
        throw GeometryError("a triangle's coordinates are not finite, or too large");
      }
      box.add(corner);
    }
  }
  if (triangles.empty()) return;
  fit_scale();
  build(threads);
  peak_bytes = triangles.capacity() * sizeof(TrianglePositions) +
               static_cast<std::size_t>(std::max<std::int64_t>(meter_.peak(), 0));
}

/// Makes `scaled` take the box into [-1, 1]: by a power of two, which rounds nothing.
void ClosestPointTree::Impl::fit_scale() {
  centre_ = 0.5 * box.low + 0.5 * box.high;
  const Vec3 half = box.high - centre_;
  const double extent = std::max({half.x, half.y, half.z});
  if (extent > 0) scale_ = std::ldexp(1.0, -std::max(std::ilogb(extent), -1000) - 1);
}

void ClosestPointTree::Impl::build(unsigned threads) {
  const unsigned builders = kParallelBuild ? std::max(threads, 1u) : 1u;
  device_.reset(rtcNewDevice(("threads=" + std::to_string(builders)).c_str()));
  check_device(device_.get());
  rtcSetDeviceMemoryMonitorFunction(device_.get(), MemoryMeter::count, &meter_);

  const Geometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(triangles.size()));
  rtcSetGeometryUserData(geometry.get(), this);
  rtcSetGeometryBoundsFunction(geometry.get(), bound, nullptr);
  rtcCommitGeometry(geometry.get());

  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_COMPACT);
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_LOW);
  rtcAttachGeometry(scene_.get(), geometry.get());
  rtcCommitScene(scene_.get());
  check_device(device_.get());
}

void ClosestPointTree::Impl::bound(const RTCBoundsFunctionArguments* arguments) {
  const Impl& tree = *static_cast<const Impl*>(arguments->geometryUserPtr);
  Box3 box;
  for (const Vec3& corner : tree.triangles[arguments->primID]) box.add(tree.scaled(corner));
  const Vec3f low = to_float(box.low);
  const Vec3f high = to_float(box.high);
  *arguments->bounds_o = {low.x, low.y, low.z, 0, high.x, high.y, high.z, 0};
}

bool ClosestPointTree::Impl::visit(RTCPointQueryFunctionArguments* arguments) {
  Query& query = *static_cast<Query*>(arguments->userPtr);
  if (!query.consider(arguments->primID)) return false;
  arguments->query->radius = query.radius();
  return true;
}

ClosestPoint ClosestPointTree::Impl::closest(const Vec3& p, double bound2, LocalIndex hint) const {
  const Vec3 q = scaled(p);
  const double reach = std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  Query query{.tree = *this,
              .p = p,
              .margin = kAbsoluteMargin * (1 + reach),
              .best = {.triangle = kNoIndex, .distance2 = bound2, .weights = {}}};
  if (triangles.empty() || box_distance2(p, box) * (1 - kRelativeMargin) > bound2) return {};
  if (hint != kNoIndex) query.consider(hint);
  if (reach < kFar) {
    const Vec3f centre = to_float(q);
    RTCPointQuery sphere{centre.x, centre.y, centre.z, 0, query.radius()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_.get(), &sphere, &context, visit, &query);
  } else {
    for (std::size_t i = 0; i < triangles.size(); ++i) query.consider(static_cast<LocalIndex>(i));
  }
  return query.best.triangle == kNoIndex ? ClosestPoint{} : query.best;
}

ClosestPointTree::ClosestPointTree(std::vector<TrianglePositions> triangles, unsigned threads)
    : impl_(std::make_unique<Impl>(std::move(triangles), threads)) {}
ClosestPointTree::~ClosestPointTree() = default;
ClosestPointTree::ClosestPointTree(ClosestPointTree&&) noexcept = default;
ClosestPointTree& ClosestPointTree::operator=(ClosestPointTree&&) noexcept = default;

ClosestPoint ClosestPointTree::closest(const Vec3& p, double bound2, LocalIndex hint) const {
  return impl_->closest(p, bound2, hint);
}
const std::vector<TrianglePositions>& ClosestPointTree::triangles() const {
  return impl_->triangles;
}
const Box3& ClosestPointTree::box() const {
  return impl_->box;
}
std::size_t ClosestPointTree::peak_bytes() const {
  return impl_->peak_bytes;
}
std::vector<TrianglePositions> ClosestPointTree::release() && {
  std::vector<TrianglePositions> triangles = std::move(impl_->triangles);
  impl_.reset();
  return triangles;
}

}  // namespace remaps
