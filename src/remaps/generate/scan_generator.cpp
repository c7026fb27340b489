#include "remaps/generate/scan_generator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/base/workers.h"
#include "remaps/generate/hash_mix.h"

namespace remaps {
namespace {

constexpr std::uint64_t kChunk = 1 << 15;
constexpr std::uint64_t kMaxVertices = std::uint64_t{1} << 60;

/// Jitter 1 in grid edges. The flattest triangle, half of a flipped pair, is 1/2 high; as its apex
/// and its base may each move by this much towards the other, anything below 1/4 leaves it upright.
constexpr double kMaxJitter = 0.22;

/// An octave is shown when its wavelength spans at least so many mesh edges.
constexpr double kEdgesPerWavelength = 4;

/// Each use of the seed hashes with a constant of its own.
enum class SeedUse : std::uint64_t { kJitter = 1, kFlips, kNoise, kVertexOrder, kFaceOrder };

std::uint64_t seed_for(const GeneratorOptions& options, SeedUse use) {
  return hash_key(options.seed, static_cast<std::uint64_t>(use));
}

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

GeneratorOptions checked(GeneratorOptions options) {
  require(options.amplitude >= 0 && std::isfinite(options.amplitude), "amplitude must be >= 0");
  require(options.wavelength > 0 && std::isfinite(options.wavelength), "wavelength must be > 0");
  require(options.roughness > 0 && options.roughness <= 1, "roughness must be in (0, 1]");
  require(options.octaves >= 1 && options.octaves <= 24, "octaves must be 1 to 24");
  require(options.jitter >= 0 && options.jitter <= 1, "jitter must be in [0, 1]");
  require(options.flip_fraction >= 0 && options.flip_fraction <= 1,
          "flip fraction must be in [0, 1]");
  if (options.vertices > kMaxVertices) throw GeometryError("more than 2^60 vertices wanted");
  return options;
}

ShapeMesh take_base(GeneratorOptions& options) {
  if (const auto* shape = std::get_if<BaseShape>(&options.base)) return make_base_mesh(*shape);
  return std::move(std::get<ShapeMesh>(options.base));
}

PatchGrid divide(const ShapeMesh& base, std::uint64_t target) {
  const std::uint64_t vertices = base.positions.size();
  return {base.triangles, vertices, PatchGrid::nearest_n(base.triangles, vertices, target)};
}

int visible_octaves(const GeneratorOptions& options, const SmoothBase& base,
                    const PatchGrid& grid) {
  const double edge = base.mean_edge() / static_cast<double>(grid.n());
  const double finest = kEdgesPerWavelength * edge;
  int octaves = 1;
  double wavelength = options.wavelength * base.diagonal() / 2;
  for (; octaves < options.octaves && wavelength >= finest; wavelength /= 2) ++octaves;
  return octaves;
}

/// Barycentrics of a grid point after its jitter: within a hexagon about an interior point, along
/// the edge for a point on a base edge, none at a base vertex.
/// @param reach  radius of the jitter, in grid edges
Vec3 jittered(const PatchPoint& p, std::uint64_t n, double reach, std::uint64_t hash) {
  const bool on_ab = p.column == 0;
  const bool on_bc = p.row == n;
  const bool on_ca = p.column == p.row;
  // How far to go along A to B, B to C, C to A: three unit vectors at 120 degrees.
  constexpr std::uint64_t kMask = (1 << 21) - 1;
  const auto step = [&](int part) {
    return reach * static_cast<double>((hash >> (21 * part)) & kMask) / kMask;
  };
  Vec3 go{step(0), step(1), step(2)};
  if (on_ab || on_bc || on_ca) {
    const double along = 2 * go.x - reach;
    const bool at_corner = int{on_ab} + int{on_bc} + int{on_ca} > 1;
    go = at_corner ? Vec3{} : along * Vec3{on_ab ? 1. : 0., on_bc ? 1. : 0., on_ca ? 1. : 0.};
  }
  const Vec3 grid{static_cast<double>(n - p.row), static_cast<double>(p.row - p.column),
                  static_cast<double>(p.column)};
  const Vec3 drift{go.z - go.x, go.x - go.y, go.y - go.z};
  return 1 / static_cast<double>(n) * (grid + drift);
}

/// Sends items 0 to n - 1 in chunks; threads compute chunks, the sink gets them in order.
template <class Item, class Sink, class Make>
void stream_chunks(std::uint64_t n, unsigned threads, const Sink& sink, const Make& make) {
  const std::uint64_t chunks = n / kChunk + (n % kChunk != 0 ? 1 : 0);
  run_ordered(narrow<std::size_t>(chunks), threads, [&](std::size_t i, unsigned) -> Commit {
    const std::uint64_t first = i * kChunk;
    auto items = std::make_shared<std::vector<Item>>(std::min(kChunk, n - first));
    for (std::uint64_t k = 0; k < items->size(); ++k) (*items)[k] = make(first + k);
    return [items = std::move(items), &sink] { sink(*items); };
  });
}

}  // namespace

ScanGenerator::ScanGenerator(GeneratorOptions options)
    : options_(checked(std::move(options))),
      base_(take_base(options_)),
      grid_(divide(base_.mesh(), options_.vertices)),
      flips_(seed_for(options_, SeedUse::kFlips), options_.flip_fraction),
      noise_(seed_for(options_, SeedUse::kNoise), visible_octaves(options_, base_, grid_),
             options_.roughness),
      vertex_order_(grid_.vertices(), seed_for(options_, SeedUse::kVertexOrder)),
      face_order_(grid_.faces(), seed_for(options_, SeedUse::kFaceOrder)) {}

Vec3 ScanGenerator::vertex(VertexId i) const {
  const VertexId coherent = options_.shuffled ? vertex_order_.forward(i) : i;
  const PatchPoint p = grid_.point(coherent);
  const double reach = kMaxJitter * options_.jitter;
  const std::uint64_t hash = mix_bits(seed_for(options_, SeedUse::kJitter) + coherent);
  const SurfaceFrame frame = base_.frame(p.face, jittered(p, grid_.n(), reach, hash));
  const double height =
      noise_(1 / (options_.wavelength * base_.diagonal()) * frame.position) * options_.amplitude;
  return frame.position + height * base_.diagonal() * frame.normal;
}

Triangle ScanGenerator::triangle(FaceId i) const {
  const FaceId coherent = options_.shuffled ? face_order_.forward(i) : i;
  Triangle result{};
  const auto corners = flips_.corners(grid_, grid_.triangle(coherent));
  for (std::size_t k = 0; k < 3; ++k) {
    const VertexId v = grid_.vertex(corners[k]);
    result[k] = options_.shuffled ? vertex_order_.inverse(v) : v;
  }
  return result;
}

void ScanGenerator::positions(PositionSink sink, unsigned threads) const {
  stream_chunks<Vec3>(vertices(), threads, sink, [this](VertexId i) { return vertex(i); });
}

void ScanGenerator::triangles(IndexSink sink, unsigned threads) const {
  stream_chunks<Triangle>(faces(), threads, sink, [this](FaceId i) { return triangle(i); });
}

}  // namespace remaps
