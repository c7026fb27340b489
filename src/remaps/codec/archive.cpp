#include "remaps/codec/archive.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps::codec {
namespace {

constexpr std::array<char, 8> kMagic = {'r', 'e', 'm', 'a', 'p', 's', 'G', 'A'};
constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 68;
constexpr std::size_t kChecksumBytes = 4;
/// Code between checksums.
constexpr std::size_t kBlockBytes = 4096;
constexpr std::size_t kRatePointBytes = 8;

constexpr std::uint64_t kEncoderBytesPerVertex = 110;
constexpr std::uint64_t kDecoderBytesPerVertex = 64;

/// The largest detail counts as at least this part of the diagonal, so that flat surfaces do not
/// get steps of nothing.
constexpr double kLeastDetail = 0x1p-8;
constexpr double kStepsPerOctave = 4;
/// Cells of the base's grid along the diagonal, about: coarser ones would leave the prediction of
/// base vertices too little to do.
constexpr double kGridCells = 512;

std::uint32_t checksum(store::ByteSpan bytes) {
  return static_cast<std::uint32_t>(XXH3_64bits(bytes.data(), bytes.size()));
}

std::uint64_t with_checksums(std::uint64_t code_bytes) {
  return code_bytes + kChecksumBytes * ((code_bytes + kBlockBytes - 1) / kBlockBytes);
}

void append(store::Bytes& out, store::ByteSpan bytes) {
  store::Packer(out).put_array(bytes);
}

store::Bytes pack_header(const ArchiveHeader& header) {
  const Quantization& q = header.quantization;
  store::Bytes out;
  store::Packer packer(out);
  packer.put(kMagic);
  for (const std::uint8_t value :
       {kVersion, static_cast<std::uint8_t>(q.wavelet), header.levels, q.planes, q.level_ratio,
        q.tangential, q.grid_shift, static_cast<std::uint8_t>(header.rate_points)}) {
    packer.put(value);
  }
  for (const double value : {q.origin.x, q.origin.y, q.origin.z, q.step}) packer.put(value);
  for (const std::uint32_t value :
       {header.base_vertices, header.base_faces, header.base_bytes, header.geometry_bytes}) {
    packer.put(value);
  }
  packer.put(checksum(out));
  return out;
}

/// Reads the fields; the checksum has been compared.
ArchiveHeader unpack_header(store::ByteSpan bytes, const std::string& name) {
  ArchiveHeader header;
  Quantization& q = header.quantization;
  store::Unpacker in(bytes.subspan(kMagic.size() + 1), name);
  const auto wavelet = in.get<std::uint8_t>();
  header.levels = in.get<std::uint8_t>();
  q.planes = in.get<std::uint8_t>();
  q.level_ratio = in.get<std::uint8_t>();
  q.tangential = in.get<std::uint8_t>();
  q.grid_shift = in.get<std::uint8_t>();
  header.rate_points = in.get<std::uint8_t>();
  q.origin.x = in.get<double>();
  q.origin.y = in.get<double>();
  q.origin.z = in.get<double>();
  q.step = in.get<double>();
  header.base_vertices = in.get<std::uint32_t>();
  header.base_faces = in.get<std::uint32_t>();
  header.base_bytes = in.get<std::uint32_t>();
  header.geometry_bytes = in.get<std::uint32_t>();
  q.wavelet = static_cast<Wavelet>(wavelet);
  const bool fits = wavelet <= static_cast<std::uint8_t>(Wavelet::kLoop) &&
                    header.levels <= SubdivisionHierarchy::kMostLevels && q.planes >= 1 &&
                    q.planes <= 30 && q.grid_shift <= q.planes && q.tangential != 0 &&
                    q.level_ratio != 0 && std::isfinite(q.origin.x) && std::isfinite(q.origin.y) &&
                    std::isfinite(q.origin.z) && std::isfinite(q.step) && q.step > 0 &&
                    header.base_vertices / 3 <= header.base_faces &&
                    header.base_faces >> (30 - 2 * header.levels) == 0;
  if (!fits) throw CorruptionError(name + ": header: a value is outside its range");
  return header;
}

/// Copies positions to where the vertices are when the base is in another order.
class Reordering {
 public:
  Reordering(const BaseOrder& order, unsigned levels) : order_(order), levels_(levels) {}

  bool is_identity() const {
    for (std::size_t v = 0; v < order_.vertex.size(); ++v) {
      if (order_.vertex[v] != v) return false;
    }
    for (std::size_t f = 0; f < order_.face.size(); ++f) {
      if (order_.face[f] != f || order_.rotation[f] != 0) return false;
    }
    return true;
  }

  std::vector<Face> base(std::span<const Face> faces) const {
    std::vector<Face> result(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        result[order_.face[f]][(k + order_.rotation[f]) % 3] = order_.vertex[faces[f][k]];
      }
    }
    return result;
  }

  /// Children turn with their parents: child k becomes child k + rotation, the middle one stays.
  std::vector<Vec3> positions(const SubdivisionHierarchy& from, const SubdivisionHierarchy& to,
                              std::span<const Vec3> x) const {
    std::vector<Vec3> result(x.size());
    const std::uint64_t children = std::uint64_t{1} << (2 * levels_);
    for (std::uint64_t i = 0; i < from.faces(); ++i) {
      const auto f = static_cast<std::size_t>(i >> (2 * levels_));
      const std::uint32_t turn = order_.rotation[f];
      std::uint64_t path = i & (children - 1);
      if (turn != 0) {
        std::uint64_t turned = 0;
        for (unsigned shift = 0; shift < 2 * levels_; shift += 2) {
          const std::uint64_t digit = path >> shift & 3;
          turned |= (digit == 3 ? 3 : (digit + turn) % 3) << shift;
        }
        path = turned;
      }
      const Face source = from.finest_face(i);
      const Face target = to.finest_face(order_.face[f] * children + path);
      for (std::uint32_t k = 0; k < 3; ++k) result[target[(k + turn) % 3]] = x[source[k]];
    }
    return result;
  }

 private:
  const BaseOrder& order_;
  unsigned levels_;
};

/// The mesh with its base in the order in which it is coded.
SemiRegularMesh in_coding_order(SemiRegularMesh mesh, MemoryBudget& budget) {
  const BaseOrder order = order_base(mesh.base_vertices, mesh.base);
  const Reordering reordering(order, mesh.levels);
  if (reordering.is_identity()) return mesh;
  SemiRegularMesh result;
  result.base_vertices = mesh.base_vertices;
  result.levels = mesh.levels;
  result.base = reordering.base(mesh.base);
  const SubdivisionHierarchy from(mesh.base_vertices, mesh.base, mesh.levels, budget);
  const SubdivisionHierarchy to(mesh.base_vertices, result.base, mesh.levels, budget);
  result.position = reordering.positions(from, to, mesh.position);
  return result;
}

double largest_detail(const SubdivisionHierarchy& hierarchy, const Quantization& unit,
                      std::span<const Vec3> details) {
  double largest = 0;
  for (unsigned m = 1; m <= hierarchy.levels(); ++m) {
    double normal = 0, tangential = 0;
    for (std::uint32_t v = hierarchy.vertices(m - 1); v < hierarchy.vertices(m); ++v) {
      normal = std::max(normal, std::fabs(details[v].x));
      tangential = std::max({tangential, std::fabs(details[v].y), std::fabs(details[v].z)});
    }
    largest = std::max({largest, normal / unit.step_of(m, 0), tangential / unit.step_of(m, 1)});
  }
  return largest;
}

Quantization choose_quantization(const SubdivisionHierarchy& hierarchy,
                                 const EncodeOptions& options, const Box3& box,
                                 std::span<const Vec3> details) {
  Quantization q;
  q.wavelet = options.wavelet;
  q.planes = static_cast<std::uint8_t>(options.bitplanes);
  q.step = 1;
  const double diagonal = box.diagonal() > 0 ? box.diagonal() : 1;
  const double largest = std::max(largest_detail(hierarchy, q, details), kLeastDetail * diagonal);
  // A step out of few, and a grid that hangs on the coordinates and not on the box: so a decoded
  // mesh is coded as it was.
  const double steps = std::ceil(kStepsPerOctave * std::log2(largest)) / kStepsPerOctave;
  q.step = std::exp2(steps - options.bitplanes);
  const double shift = std::floor(std::log2(diagonal / (kGridCells * q.step)));
  q.grid_shift = static_cast<std::uint8_t>(std::clamp(shift, 0.0, double(q.planes)));
  const auto down = [&](double x) { return std::floor(x / q.cell()) * q.cell(); };
  q.origin = {down(box.low.x), down(box.low.y), down(box.low.z)};
  return q;
}

}  // namespace

store::Bytes encode_mesh(SemiRegularMesh mesh, const EncodeOptions& options, MemoryBudget& budget) {
  Box3 box;
  for (const Vec3& p : mesh.position) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw GeometryError("a position of the mesh is not finite");
    }
    box.add(p);
  }
  const Reservation memory = budget.reserve(mesh.position.size() * kEncoderBytesPerVertex,
                                            "the details of the mesh to be encoded");
  mesh = in_coding_order(std::move(mesh), budget);
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  if (hierarchy.vertices() != mesh.position.size()) {
    throw GeometryError(fmt::format("{} positions for the {} vertices of the base at level {}",
                                    mesh.position.size(), hierarchy.vertices(), mesh.levels));
  }
  to_details(hierarchy, options.wavelet, mesh.position, options.progress);

  ArchiveHeader header;
  Quantization& q = header.quantization;
  for (std::uint32_t v = 0; v < mesh.base_vertices; ++v) box.add(mesh.position[v]);
  q = choose_quantization(hierarchy, options, box, mesh.position);
  GridBase base;
  base.face = mesh.base;
  for (std::uint32_t v = 0; v < mesh.base_vertices; ++v) {
    base.position.push_back(grid_cell(q, mesh.position[v]));
  }
  Coefficients coefficients;
  quantize(hierarchy, q, mesh.position, coefficients);
  mesh.position = {};
  const store::Bytes base_code = encode_base(base);
  const store::Bytes code = encode_coefficients(hierarchy, coefficients, q.planes);
  header.levels = static_cast<std::uint8_t>(mesh.levels);
  header.base_vertices = mesh.base_vertices;
  header.base_faces = narrow<std::uint32_t>(mesh.base.size());
  header.base_bytes = narrow<std::uint32_t>(base_code.size());
  header.geometry_bytes = narrow<std::uint32_t>(code.size());

  store::Bytes out = pack_header(header);
  append(out, base_code);
  store::Packer(out).put(checksum(base_code));
  for (std::size_t at = 0; at < code.size(); at += kBlockBytes) {
    const auto block = store::ByteSpan(code).subspan(at, std::min(kBlockBytes, code.size() - at));
    append(out, block);
    store::Packer(out).put(checksum(block));
  }
  return out;
}

Archive::Archive(store::ByteSpan bytes, std::filesystem::path name)
    : bytes_(bytes), name_(std::move(name)) {
  const std::string file = name_.string();
  if (bytes.size() < kMagic.size() ||
      std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    throw InputError(file + ": byte 0: expected \"remapsGA\", the start of an archive");
  }
  if (bytes.size() < kHeaderBytes) {
    throw InputError(fmt::format("{}: the archive ends at byte {}, within its header of {} bytes",
                                 file, bytes.size(), kHeaderBytes));
  }
  if (static_cast<std::uint8_t>(bytes[kMagic.size()]) != kVersion) {
    throw InputError(fmt::format("{}: byte 8: version {}, but this program reads version {}", file,
                                 static_cast<unsigned>(bytes[kMagic.size()]), kVersion));
  }
  const auto passes = [&](std::uint64_t at, std::uint64_t size) {
    std::uint32_t stored = 0;
    std::memcpy(&stored, bytes.data() + at + size, sizeof stored);
    return stored == checksum(bytes.subspan(at, size));
  };
  if (!passes(0, kHeaderBytes - kChecksumBytes)) {
    throw CorruptionError(file + ": the header fails its checksum");
  }
  header_ = unpack_header(bytes, file);
  if (bytes.size() > complete_bytes()) {
    throw CorruptionError(
        fmt::format("{}: {} bytes, but the archive has {}", file, bytes.size(), complete_bytes()));
  }
  if (bytes.size() < least_bytes()) {
    throw InputError(
        fmt::format("{}: the archive ends at byte {}, but header and base mesh take {}", file,
                    bytes.size(), least_bytes()));
  }
  if (!passes(kHeaderBytes, header_.base_bytes)) {
    throw CorruptionError(
        fmt::format("{}: byte {}: the base mesh fails its checksum", file, kHeaderBytes));
  }
  std::uint64_t at = least_bytes();
  for (std::uint64_t left = header_.geometry_bytes; left > 0;) {
    const std::uint64_t size = std::min<std::uint64_t>(left, kBlockBytes);
    if (at + size + kChecksumBytes > bytes.size()) return;
    if (!passes(at, size)) {
      throw CorruptionError(
          fmt::format("{}: byte {}: a block of {} bytes fails its checksum", file, at, size));
    }
    at += size + kChecksumBytes;
    left -= size;
  }
  if (!complete() || header_.rate_points == 0) return;
  const std::uint64_t size = std::uint64_t{header_.rate_points} * kRatePointBytes;
  if (!passes(at, size)) {
    throw CorruptionError(
        fmt::format("{}: byte {}: the rate-distortion table fails its checksum", file, at));
  }
  store::Unpacker in(bytes.subspan(at, size), file);
  for (std::uint32_t i = 0; i < header_.rate_points; ++i) {
    const auto rate = in.get<std::uint32_t>();
    rate_points_.push_back({rate, in.get<float>()});
  }
}

std::uint64_t Archive::least_bytes() const {
  return kHeaderBytes + std::uint64_t{header_.base_bytes} + kChecksumBytes;
}

std::uint64_t Archive::complete_bytes() const {
  const std::uint64_t table =
      header_.rate_points == 0 ? 0 : header_.rate_points * kRatePointBytes + kChecksumBytes;
  return least_bytes() + with_checksums(header_.geometry_bytes) + table;
}

SemiRegularMesh Archive::decode(std::uint64_t prefix, unsigned level, MemoryBudget& budget) const {
  const std::string file = name_.string();
  if (prefix < least_bytes()) {
    throw InputError(fmt::format("{}: header and base mesh alone take {} bytes, more than {}", file,
                                 least_bytes(), prefix));
  }
  const std::uint64_t end = std::min<std::uint64_t>(prefix, bytes_.size());
  store::Bytes code;
  std::uint64_t left = header_.geometry_bytes;
  for (std::uint64_t at = least_bytes(); at < end && left > 0;) {
    const std::uint64_t size = std::min<std::uint64_t>(left, kBlockBytes);
    append(code, bytes_.subspan(at, std::min(size, end - at)));
    at += size + kChecksumBytes;
    left -= size;
  }

  const Reservation memory = budget.reserve(
      (std::uint64_t{header_.base_faces} << (2 * header_.levels)) / 2 * kDecoderBytesPerVertex,
      "the details of the mesh to be decoded");
  try {
    GridBase base = decode_base(bytes_.subspan(kHeaderBytes, header_.base_bytes),
                                header_.base_vertices, header_.base_faces);
    const SubdivisionHierarchy hierarchy(header_.base_vertices, base.face, header_.levels, budget);
    const Quantization& q = header_.quantization;
    Coefficients coefficients;
    decode_coefficients(hierarchy, code, q.planes, coefficients);
    SemiRegularMesh mesh;
    mesh.levels = std::min<unsigned>(level, header_.levels);
    mesh.position = dequantize(hierarchy, q, base.position, mesh.levels, coefficients);
    coefficients = {};
    from_details(hierarchy, q.wavelet, mesh.levels, mesh.position);
    mesh.base_vertices = header_.base_vertices;
    mesh.base = std::move(base.face);
    return mesh;
  } catch (const GeometryError& error) {
    throw CorruptionError(file + ": " + error.what());
  }
}

store::Bytes seal_archive(store::ByteSpan bytes, std::uint64_t keep,
                          std::span<const RatePoint> points) {
  const Archive archive(bytes, "archive");
  ArchiveHeader header = archive.header();
  const std::uint64_t start = archive.least_bytes();
  const std::uint64_t room = std::max(std::min<std::uint64_t>(keep, bytes.size()), start) - start;
  store::Bytes code;
  for (std::uint64_t at = 0; at < room && code.size() < header.geometry_bytes;
       at += kBlockBytes + kChecksumBytes) {
    const std::uint64_t size =
        std::min<std::uint64_t>(kBlockBytes, header.geometry_bytes - code.size());
    // A block that is cut needs room for its checksum too.
    const std::uint64_t there = std::min<std::uint64_t>(size + kChecksumBytes, room - at);
    if (there <= kChecksumBytes) break;
    append(code, bytes.subspan(start + at, there - kChecksumBytes));
  }
  header.geometry_bytes = static_cast<std::uint32_t>(code.size());
  header.rate_points = static_cast<std::uint32_t>(points.size());
  store::Bytes out = pack_header(header);
  append(out, bytes.subspan(kHeaderBytes, header.base_bytes + kChecksumBytes));
  for (std::size_t at = 0; at < code.size(); at += kBlockBytes) {
    const auto block = store::ByteSpan(code).subspan(at, std::min(kBlockBytes, code.size() - at));
    append(out, block);
    store::Packer(out).put(checksum(block));
  }
  if (points.empty()) return out;
  store::Bytes table;
  for (const RatePoint& point : points) {
    store::Packer(table).put(point.bytes);
    store::Packer(table).put(point.psnr_db);
  }
  append(out, table);
  store::Packer(out).put(checksum(table));
  return out;
}

}  // namespace remaps::codec
