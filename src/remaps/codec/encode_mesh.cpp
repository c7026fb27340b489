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
/// Of choosing steps by the details along the decoder's axes, which depend on the steps; as a rule
/// the first choice stays.
constexpr int kMostTrials = 4;
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

/// The length that steps are chosen for.
double size_of(std::span<const Vec3> positions) {
  Box3 box;
  for (const Vec3& p : positions) box.add(p);
  const double diagonal = box.diagonal() > 0 ? box.diagonal() : 1;
  return std::max(diagonal, kLeastDiagonal * std::max(norm(box.low), norm(box.high)));
}

ArchiveHeader start_header(const SubdivisionHierarchy& hierarchy, const EncodeOptions& options) {
  ArchiveHeader header;
  header.wavelet = options.wavelet;
  header.levels = static_cast<std::uint8_t>(hierarchy.levels());
  header.base_vertices = hierarchy.vertices(0);
  header.base_faces = static_cast<std::uint32_t>(hierarchy.base().size());
  header.quantization.planes = static_cast<std::uint8_t>(options.bitplanes);
  return header;
}

/// Chooses steps and grid.
/// @param largest  the largest detail
/// @param base     positions of the base vertices
void choose_steps(ArchiveHeader& header, double diagonal, double largest,
                  std::span<const Vec3> base) {
  Quantization& q = header.quantization;
  largest = std::max(largest, kLeastDetail * diagonal);
  if (!std::isfinite(diagonal) || !std::isfinite(largest) || largest < kLeastLargest) {
    throw GeometryError(fmt::format("positions of a size of {:g} are outside of what can be coded",
                                    std::max(diagonal, largest)));
  }
  const double steps = std::ceil(kStepsPerOctave * std::log2(largest)) / kStepsPerOctave;
  q.step = std::exp2(steps - q.planes);
  const double shift = std::floor(std::log2(diagonal / (kGridCells * q.step)));
  header.grid_shift = static_cast<std::uint8_t>(std::clamp(shift, 0.0, double(q.planes)));
  Box3 box;
  for (const Vec3& p : base) box.add(p);
  const double cell = header.grid().cell;
  if (!(box.diagonal() < kMostCells * cell)) {
    throw GeometryError("the coarsest level of the mesh is far larger than the mesh");
  }
  const auto down = [&](double x) { return std::floor(x / cell) * cell; };
  header.origin = {down(box.low.x), down(box.low.y), down(box.low.z)};
}

/// Codes the surface: chooses steps, puts base vertices on their grid and rounds what is left of
/// them with the details.
/// @param positions  (vertices) of the finest level; not kept
store::Bytes encode_geometry(const SubdivisionHierarchy& hierarchy, const EncodeOptions& options,
                             std::vector<Vec3> positions, ArchiveHeader& header,
                             store::Bytes& base_code) {
  const double diagonal = size_of(positions);
  const Quantization of_steps_of_one = header.quantization;
  double largest =
      to_details(hierarchy, options.wavelet, of_steps_of_one, positions, options.progress);
  const std::vector<Vec3> base(positions.begin(), positions.begin() + hierarchy.vertices(0));
  Coefficients coefficients;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    const double step = header.quantization.step;
    choose_steps(header, diagonal, largest, base);
    if (trial > 0 && header.quantization.step == step) break;
    const BaseGrid grid = header.grid();
    GridBase on_grid;
    on_grid.face.assign(hierarchy.base().begin(), hierarchy.base().end());
    std::vector<Vec3> centre;
    for (std::size_t v = 0; v < base.size(); ++v) {
      on_grid.position.push_back(grid.cell_of(base[v]));
      centre.push_back(grid.centre_of(on_grid.position.back()));
      positions[v] = base[v] - centre.back();
    }
    base_code = encode_base(on_grid);
    coefficients = {};
    // Along the decoder's axes, which are turned a little, the largest detail may be another one.
    largest = header.quantization.step * quantize_details(hierarchy, options.wavelet,
                                                          header.quantization, centre, positions,
                                                          coefficients, options.progress);
  }
  positions = {};
  return encode_coefficients(hierarchy, coefficients, header.quantization.planes);
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
  ArchiveHeader header = start_header(hierarchy, options);
  store::Bytes base;
  const store::Bytes geometry =
      encode_geometry(hierarchy, options, std::exchange(mesh.position, {}), header, base);
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
