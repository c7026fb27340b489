#include "remaps/codec/archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/codec/archive_writer.h"
#include "remaps/codec/checked_blocks.h"

namespace remaps::codec {
namespace {

constexpr std::array<char, 8> kMagic = {'r', 'e', 'm', 'a', 'p', 's', 'G', 'A'};
constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 68;
constexpr std::size_t kSignalHeaderBytes = 16;
constexpr std::size_t kRatePointBytes = 8;
constexpr unsigned kMostPlanes = 30;

constexpr std::uint64_t kDecoderBytesPerVertex = 68;
constexpr std::uint64_t kSignalBytesPerVertex = sizeof(Vec3);

store::Bytes pack_header(const ArchiveHeader& header) {
  const Quantization& q = header.quantization;
  store::Bytes out;
  store::Packer packer(out);
  packer.put(kMagic);
  for (const std::uint8_t value :
       {kVersion, static_cast<std::uint8_t>(header.wavelet), header.levels, q.planes, q.level_ratio,
        q.tangential, header.grid_shift, static_cast<std::uint8_t>(header.rate_points)}) {
    packer.put(value);
  }
  for (const double x : {header.origin.x, header.origin.y, header.origin.z, q.step}) {
    packer.put(x);
  }
  for (const std::uint32_t value : {header.base_vertices, header.base_faces, header.base_bytes,
                                    header.geometry_bytes, header.signal_bytes}) {
    packer.put(value);
  }
  return out;
}

bool is_sound(const Quantization& q) {
  return q.planes >= 1 && q.planes <= kMostPlanes && q.tangential != 0 && q.level_ratio != 0 &&
         std::isfinite(q.step) && q.step > 0;
}

/// Reads the fields; the checksum has been compared.
ArchiveHeader unpack_header(store::ByteSpan bytes, const std::string& name) {
  ArchiveHeader header;
  Quantization& q = header.quantization;
  store::Unpacker in(bytes.subspan(kMagic.size() + 1), name);
  const auto wavelet = in.get<std::uint8_t>();
  header.wavelet = static_cast<Wavelet>(wavelet);
  header.levels = in.get<std::uint8_t>();
  q.planes = in.get<std::uint8_t>();
  q.level_ratio = in.get<std::uint8_t>();
  q.tangential = in.get<std::uint8_t>();
  header.grid_shift = in.get<std::uint8_t>();
  header.rate_points = in.get<std::uint8_t>();
  for (double* x : {&header.origin.x, &header.origin.y, &header.origin.z, &q.step}) {
    *x = in.get<double>();
  }
  for (std::uint32_t* value : {&header.base_vertices, &header.base_faces, &header.base_bytes,
                               &header.geometry_bytes, &header.signal_bytes}) {
    *value = in.get<std::uint32_t>();
  }
  const bool fits = is_sound(q) && wavelet <= static_cast<std::uint8_t>(Wavelet::kLoop) &&
                    header.levels <= SubdivisionHierarchy::kMostLevels &&
                    header.grid_shift <= q.planes && header.rate_points <= kMostRatePoints &&
                    std::isfinite(header.origin.x) && std::isfinite(header.origin.y) &&
                    std::isfinite(header.origin.z) &&
                    header.base_vertices / 3 <= header.base_faces &&
                    header.base_faces >> (30 - 2 * header.levels) == 0;
  if (!fits) throw CorruptionError(name + ": header: a value is outside its range");
  return header;
}

store::Bytes pack_signal_header(const SignalHeader& header) {
  const Quantization& q = header.quantization;
  store::Bytes out;
  out.reserve(kSignalHeaderBytes);
  store::Packer packer(out);
  for (const std::uint8_t value :
       {static_cast<std::uint8_t>(header.kind), q.planes, q.level_ratio, q.tangential}) {
    packer.put(value);
  }
  packer.put(q.step);
  packer.put(header.bytes);
  return out;
}

SignalHeader unpack_signal_header(store::ByteSpan bytes, const std::string& name) {
  SignalHeader header;
  Quantization& q = header.quantization;
  store::Unpacker in(bytes, name);
  const auto kind = in.get<std::uint8_t>();
  header.kind = static_cast<SignalKind>(kind);
  q.planes = in.get<std::uint8_t>();
  q.level_ratio = in.get<std::uint8_t>();
  q.tangential = in.get<std::uint8_t>();
  q.step = in.get<double>();
  header.bytes = in.get<std::uint32_t>();
  const bool known = header.kind == SignalKind::kColour || header.kind == SignalKind::kNormal;
  if (!known || !is_sound(q)) {
    throw CorruptionError(name + ": header of a signal: a value is outside its range");
  }
  return header;
}

std::uint64_t bytes_of_signal(std::uint64_t code_bytes) {
  return kSignalHeaderBytes + kChecksumBytes + bytes_in_blocks(code_bytes);
}

/// Shortens a code so that it fits, with the checksums of its blocks.
void cut(store::Bytes& code, std::uint64_t room) {
  const std::uint64_t full = room / (kBlockBytes + kChecksumBytes);
  const std::uint64_t rest = room % (kBlockBytes + kChecksumBytes);
  const std::uint64_t fits =
      full * kBlockBytes + (rest > kChecksumBytes ? rest - kChecksumBytes : 0);
  if (fits < code.size()) code.erase(code.begin() + static_cast<std::ptrdiff_t>(fits), code.end());
}

}  // namespace

BaseGrid ArchiveHeader::grid() const {
  return {origin, quantization.step * static_cast<double>(std::uint64_t{1} << grid_shift)};
}

std::uint64_t rate_table_bytes(std::size_t points) {
  return points == 0 ? 0 : points * kRatePointBytes + kChecksumBytes;
}

store::Bytes assemble_archive(const ArchiveHeader& given, store::ByteSpan base,
                              store::ByteSpan geometry,
                              std::span<const std::pair<SignalHeader, store::Bytes>> signals,
                              std::span<const RatePoint> points) {
  ArchiveHeader header = given;
  header.base_bytes = narrow<std::uint32_t>(base.size());
  header.geometry_bytes = narrow<std::uint32_t>(geometry.size());
  header.rate_points = narrow<std::uint8_t>(points.size());
  std::uint64_t signal_bytes = 0;
  for (const auto& [head, code] : signals) signal_bytes += bytes_of_signal(code.size());
  header.signal_bytes = narrow<std::uint32_t>(signal_bytes);
  store::Bytes out;
  append_checked(out, pack_header(header));
  append_checked(out, base);
  append_in_blocks(out, geometry);
  for (const auto& [head, code] : signals) {
    SignalHeader cut = head;
    cut.bytes = narrow<std::uint32_t>(code.size());
    append_checked(out, pack_signal_header(cut));
    append_in_blocks(out, code);
  }
  if (points.empty()) return out;
  store::Bytes table;
  for (const RatePoint& point : points) {
    store::Packer(table).put(point.bytes);
    store::Packer(table).put(point.psnr_db);
  }
  append_checked(out, table);
  return out;
}

Archive::Archive(store::ByteSpan bytes, std::filesystem::path name)
    : bytes_(bytes), name_(std::move(name)) {
  const std::string file = name_.string();
  if (bytes.size() < kMagic.size() ||
      std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    throw InputError(file + ": byte 0: expected \"remapsGA\", the start of an archive");
  }
  if (bytes.size() < kHeaderBytes + kChecksumBytes) {
    throw InputError(fmt::format("{}: the archive ends at byte {}, within its header of {} bytes",
                                 file, bytes.size(), kHeaderBytes + kChecksumBytes));
  }
  if (static_cast<std::uint8_t>(bytes[kMagic.size()]) != kVersion) {
    throw InputError(fmt::format("{}: byte 8: version {}, but this program reads version {}", file,
                                 static_cast<unsigned>(bytes[kMagic.size()]), kVersion));
  }
  if (!passes_checksum(bytes, 0, kHeaderBytes)) {
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
  const std::uint64_t base = kHeaderBytes + kChecksumBytes;
  if (!passes_checksum(bytes, base, header_.base_bytes)) {
    throw CorruptionError(fmt::format("{}: byte {}: the base mesh fails its checksum", file, base));
  }
  check_blocks(least_bytes(), header_.geometry_bytes);
  find_signals();
  if (complete() && header_.rate_points > 0) read_rate_points();
}

void Archive::check_blocks(std::uint64_t at, std::uint64_t code_bytes) const {
  const auto there = bytes_.subspan(std::min<std::uint64_t>(at, bytes_.size()));
  const auto bad = first_bad_block(
      there.first(std::min<std::uint64_t>(there.size(), bytes_in_blocks(code_bytes))), code_bytes);
  if (bad) {
    throw CorruptionError(fmt::format("{}: byte {}: a block of the code fails its checksum",
                                      name_.string(), at + *bad));
  }
}

void Archive::find_signals() {
  std::uint64_t at = geometry_end();
  const std::uint64_t end = at + header_.signal_bytes;
  while (at < end && at + kSignalHeaderBytes + kChecksumBytes <= bytes_.size()) {
    if (!passes_checksum(bytes_, at, kSignalHeaderBytes)) {
      throw CorruptionError(fmt::format("{}: byte {}: the header of a signal fails its checksum",
                                        name_.string(), at));
    }
    const SignalHeader header =
        unpack_signal_header(bytes_.subspan(at, kSignalHeaderBytes), name_.string());
    if (bytes_of_signal(header.bytes) > end - at) {
      throw CorruptionError(fmt::format("{}: byte {}: a signal is longer than all signals together",
                                        name_.string(), at));
    }
    signals_.push_back({header, at + kSignalHeaderBytes + kChecksumBytes});
    check_blocks(signals_.back().offset, header.bytes);
    at += bytes_of_signal(header.bytes);
  }
}

void Archive::read_rate_points() {
  const std::uint64_t at = geometry_end() + header_.signal_bytes;
  const std::uint64_t size = std::uint64_t{header_.rate_points} * kRatePointBytes;
  if (!passes_checksum(bytes_, at, size)) {
    throw CorruptionError(fmt::format("{}: byte {}: the rate-distortion table fails its checksum",
                                      name_.string(), at));
  }
  store::Unpacker in(bytes_.subspan(at, size), name_.string());
  for (std::uint32_t i = 0; i < header_.rate_points; ++i) {
    const auto rate = in.get<std::uint32_t>();
    rate_points_.push_back({rate, in.get<float>()});
  }
}

std::vector<SignalHeader> Archive::signals() const {
  std::vector<SignalHeader> headers;
  for (const SignalPlace& signal : signals_) headers.push_back(signal.header);
  return headers;
}

std::uint64_t Archive::least_bytes() const {
  return kHeaderBytes + std::uint64_t{header_.base_bytes} + 2 * kChecksumBytes;
}

std::uint64_t Archive::geometry_end() const {
  return least_bytes() + bytes_in_blocks(header_.geometry_bytes);
}

std::uint64_t Archive::complete_bytes() const {
  return geometry_end() + header_.signal_bytes + rate_table_bytes(header_.rate_points);
}

SemiRegularMesh Archive::decode(std::uint64_t prefix, unsigned level, MemoryBudget& budget,
                                bool with_signals) const {
  const std::string file = name_.string();
  if (prefix < least_bytes()) {
    throw InputError(fmt::format("{}: header and base mesh alone take {} bytes, more than {}", file,
                                 least_bytes(), prefix));
  }
  const store::ByteSpan there = bytes_.first(std::min<std::uint64_t>(prefix, bytes_.size()));
  const auto code_at = [&](std::uint64_t at, std::uint64_t code_bytes) {
    return code_of_blocks(there.subspan(std::min<std::uint64_t>(at, there.size())), code_bytes);
  };
  const std::uint64_t vertices =
      (std::uint64_t{header_.base_faces} << (2 * header_.levels)) / 2 + header_.base_vertices;
  const std::uint64_t signals = with_signals ? signals_.size() : 0;
  const Reservation memory =
      budget.reserve(vertices * (kDecoderBytesPerVertex + signals * kSignalBytesPerVertex +
                                 WaveletTransform::working_bytes_per_vertex(header_.wavelet)) +
                         header_.base_faces * kBaseCodeBytesPerFace,
                     "the details of the mesh to be decoded");
  try {
    GridBase base = decode_base(bytes_.subspan(kHeaderBytes + kChecksumBytes, header_.base_bytes),
                                header_.base_vertices, header_.base_faces);
    const SubdivisionHierarchy hierarchy(header_.base_vertices, base.face, header_.levels, budget);
    SemiRegularMesh mesh;
    mesh.levels = std::min<unsigned>(level, header_.levels);
    {
      Coefficients coefficients;
      decode_coefficients(hierarchy, code_at(least_bytes(), header_.geometry_bytes),
                          header_.quantization.planes, coefficients);
      mesh.position = dequantize(hierarchy, header_.quantization, mesh.levels, coefficients);
    }
    const BaseGrid grid = header_.grid();
    for (std::size_t v = 0; v < base.position.size(); ++v) {
      mesh.position[v] = mesh.position[v] + grid.centre_of(base.position[v]);
    }
    from_details(hierarchy, header_.wavelet, mesh.levels, mesh.position);
    for (const SignalPlace& signal : signals_) {
      if (!with_signals || signal.offset > there.size()) break;
      mesh.signals.push_back(decode_signal(hierarchy, header_.wavelet, signal.header,
                                           code_at(signal.offset, signal.header.bytes),
                                           mesh.levels));
    }
    mesh.base_vertices = header_.base_vertices;
    mesh.base = std::move(base.face);
    return mesh;
  } catch (const GeometryError& error) {
    throw CorruptionError(file + ": " + error.what());
  }
}

store::Bytes seal_archive(const Archive& archive, std::uint64_t geometry, std::uint64_t signals,
                          std::span<const RatePoint> points) {
  const ArchiveHeader& header = archive.header();
  const store::ByteSpan bytes = archive.bytes_;
  const std::uint64_t start = archive.least_bytes();
  store::Bytes code = code_of_blocks(bytes.subspan(start), header.geometry_bytes);
  cut(code, geometry > start ? geometry - start : 0);
  std::vector<std::pair<SignalHeader, store::Bytes>> kept;
  for (const auto& [head, offset] : archive.signals_) {
    const double share =
        header.signal_bytes > 0 ? std::min(1.0, double(signals) / double(header.signal_bytes)) : 0;
    const auto room = static_cast<std::uint64_t>(share * double(bytes_of_signal(head.bytes)));
    if (room <= bytes_of_signal(0)) continue;
    store::Bytes part = code_of_blocks(bytes.subspan(offset), head.bytes);
    cut(part, room - bytes_of_signal(0));
    kept.emplace_back(head, std::move(part));
  }
  return assemble_archive(header, bytes.subspan(kHeaderBytes + kChecksumBytes, header.base_bytes),
                          code, kept, points);
}

}  // namespace remaps::codec
