#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/codec/archive.h"
#include "remaps/codec/archive_writer.h"

namespace remaps::codec {
namespace {

constexpr std::uint64_t kEncoderBytesPerVertex = 110;

/// The largest detail counts as at least this part of the diagonal, so that flat surfaces do not
/// get steps of nothing.
constexpr double kLeastDetail = 0x1p-8;
/// Below it, steps would have no bits any more.
constexpr double kLeastLargest = 0x1p-900;
/// Steps are a few a factor of 2, and the grid hangs on the coordinates and not on the box: so a
/// decoded mesh is coded as it was.
constexpr double kStepsPerOctave = 4;
/// Cells of the base's grid along the diagonal, about: with coarser ones the prediction of base
/// vertices would have too little to do.
constexpr double kGridCells = 512;
/// A cell's number has 27 bits, and some are left for rounding.
constexpr double kMostCells = 1 << 26;
/// Of the distance from the origin, the least that counts as the diagonal: so that cells are
/// larger than what coordinates are rounded to.
constexpr double kLeastDiagonal = 0x1p-40;

bool is_finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void check_values(const SemiRegularMesh& mesh, const SubdivisionHierarchy& hierarchy) {
  check_counts(mesh, hierarchy);
  const auto check = [&](const std::vector<Vec3>& values) {
    if (!std::all_of(values.begin(), values.end(), is_finite)) {
      throw GeometryError("a position or attribute of the mesh is not finite");
    }
  };
  check(mesh.position);
  for (const Signal& signal : mesh.signals) check(signal.value);
}

/// Chooses steps and grid.
ArchiveHeader choose_header(const SubdivisionHierarchy& hierarchy, const EncodeOptions& options,
                            double diagonal, double farthest, std::span<const Vec3> details) {
  ArchiveHeader header;
  header.wavelet = options.wavelet;
  header.levels = static_cast<std::uint8_t>(hierarchy.levels());
  header.base_vertices = hierarchy.vertices(0);
  header.base_faces = static_cast<std::uint32_t>(hierarchy.base().size());
  Quantization& q = header.quantization;
  q.planes = static_cast<std::uint8_t>(options.bitplanes);
  if (!(diagonal > 0)) diagonal = 1;
  diagonal = std::max(diagonal, kLeastDiagonal * farthest);
  const double largest = std::max(largest_detail(hierarchy, q, details), kLeastDetail * diagonal);
  if (!std::isfinite(diagonal) || !std::isfinite(largest) || largest < kLeastLargest) {
    throw GeometryError(fmt::format("positions of a size of {:g} are outside of what can be coded",
                                    std::max(diagonal, largest)));
  }
  const double steps = std::ceil(kStepsPerOctave * std::log2(largest)) / kStepsPerOctave;
  q.step = std::exp2(steps - options.bitplanes);
  const double shift = std::floor(std::log2(diagonal / (kGridCells * q.step)));
  header.grid_shift = static_cast<std::uint8_t>(std::clamp(shift, 0.0, double(q.planes)));
  Box3 box;
  for (const Vec3& p : details.first(hierarchy.vertices(0))) box.add(p);
  const double cell = header.grid().cell;
  if (!(box.diagonal() < kMostCells * cell)) {
    throw GeometryError("the coarsest level of the mesh is far larger than the mesh");
  }
  const auto down = [&](double x) { return std::floor(x / cell) * cell; };
  header.origin = {down(box.low.x), down(box.low.y), down(box.low.z)};
  return header;
}

/// Puts base vertices on their grid; what is left of each stays in the details.
store::Bytes encode_base_vertices(const SubdivisionHierarchy& hierarchy, const BaseGrid& grid,
                                  std::span<Vec3> details) {
  GridBase base;
  base.face.assign(hierarchy.base().begin(), hierarchy.base().end());
  for (Vec3& p : details.first(hierarchy.vertices(0))) {
    base.position.push_back(grid.cell_of(p));
    p = p - grid.centre_of(base.position.back());
  }
  return encode_base(base);
}

}  // namespace

store::Bytes encode_mesh(SemiRegularMesh mesh, const EncodeOptions& options, MemoryBudget& budget) {
  const Reservation memory = budget.reserve(
      mesh.position.size() * (kEncoderBytesPerVertex + mesh.signals.size() * sizeof(Vec3) +
                              WaveletTransform::working_bytes_per_vertex(options.wavelet)) +
          mesh.base.size() * kBaseCodeBytesPerFace,
      "the details of the mesh to be encoded");
  mesh = in_coding_order(std::move(mesh), budget);
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  check_values(mesh, hierarchy);
  Box3 box;
  for (const Vec3& p : mesh.position) box.add(p);
  to_details(hierarchy, options.wavelet, mesh.position, options.progress);
  const ArchiveHeader header = choose_header(
      hierarchy, options, box.diagonal(), std::max(norm(box.low), norm(box.high)), mesh.position);
  const store::Bytes base = encode_base_vertices(hierarchy, header.grid(), mesh.position);
  store::Bytes geometry;
  {
    Coefficients coefficients;
    quantize(hierarchy, header.quantization, mesh.position, coefficients);
    mesh.position = {};
    geometry = encode_coefficients(hierarchy, coefficients, header.quantization.planes);
  }
  std::vector<std::pair<SignalHeader, store::Bytes>> signals;
  for (Signal& signal : mesh.signals) {
    if (options.progress != nullptr) options.progress->check();
    SignalHeader head;
    store::Bytes code = encode_signal(hierarchy, options.wavelet, std::move(signal),
                                      options.signal_bitplanes, head);
    signals.emplace_back(head, std::move(code));
  }
  return assemble_archive(header, base, geometry, signals, {});
}

}  // namespace remaps::codec
