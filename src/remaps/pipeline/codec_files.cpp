#include "remaps/pipeline/codec_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/formats/byte_sink.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/pipeline/coded_surface.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

/// Faces of the coded mesh for each of the input's.
constexpr double kFacesPerInputFace = 12;
constexpr unsigned kFinestChosen = 8;
/// What coding takes for a vertex: positions, details, connectivity, the code.
constexpr std::uint64_t kCodingBytesPerVertex = 280;
/// Points of the rate-distortion table: a factor of sqrt(2) in bytes between each two.
constexpr unsigned kRatePoints = 14;

/// The largest archive of which a summary is made takes half of this.
constexpr std::uint64_t kSummaryBytes = std::uint64_t{8} << 30;

/// Of --max-bytes, 1 / kSignalShare goes to attributes; the table may take 1 / kTableShare.
constexpr std::uint64_t kSignalShare = 3, kTableShare = 16;

/// A step of the search for a target: bytes differ by less than this part.
constexpr double kTargetPrecision = 0.005;

/// Finds the errors of prefixes of an archive, each once.
class RateMeter {
 public:
  RateMeter(const codec::Archive& archive, const CodedSurface& surface, MemoryBudget& budget)
      : archive_(archive), surface_(surface), budget_(budget) {}

  /// PSNR in dB of a prefix.
  double psnr_at(std::uint64_t bytes) {
    for (const codec::RatePoint& p : points_) {
      if (p.bytes == bytes) return p.psnr_db;
    }
    const double l2 = surface_.l2_error(
        archive_.decode(bytes, archive_.header().levels, budget_, false), budget_);
    const double psnr = l2 > 0 ? -20 * std::log10(l2) : 999;
    points_.push_back({narrow<std::uint32_t>(bytes), static_cast<float>(psnr)});
    return psnr;
  }

 private:
  const codec::Archive& archive_;
  const CodedSurface& surface_;
  MemoryBudget& budget_;
  std::vector<codec::RatePoint> points_;
};

/// The shortest prefix that reaches a PSNR, but for a part of kTargetPrecision.
std::uint64_t reach_target(RateMeter& meter, double target, std::uint64_t least, std::uint64_t most,
                           Progress& progress) {
  const double best = meter.psnr_at(most);
  if (best < target) {
    throw GeometryError(
        fmt::format("{} bytes reach {:.2f} dB, not the {:.2f} dB that --target-psnr asks for; more "
                    "--bitplanes, "
                    "a finer --level or a larger base may",
                    most, best, target));
  }
  if (meter.psnr_at(least) >= target) return least;
  while (double(most) > (1 + kTargetPrecision) * double(least)) {
    progress.check();
    const auto middle = static_cast<std::uint64_t>(std::sqrt(double(least) * double(most)));
    if (middle <= least || middle >= most) break;
    (meter.psnr_at(middle) >= target ? most : least) = middle;
  }
  return most;
}

/// What the parts of an archive may take.
struct Shares {
  std::uint64_t geometry = 0, signals = 0;
  std::size_t points = 0;
};

Shares share_out(const codec::Archive& archive, const EncodeOptions& options) {
  const codec::ArchiveHeader& header = archive.header();
  const bool measure = options.measure || options.target_psnr.has_value();
  Shares shares{archive.geometry_end(), header.signal_bytes, measure ? kRatePoints : 0};
  if (!options.max_bytes) return shares;
  std::uint64_t room = *options.max_bytes;
  if (room < archive.least_bytes()) {
    throw BudgetError(fmt::format("--max-bytes {}: header and base mesh alone take {}", room,
                                  archive.least_bytes()));
  }
  // A table that would take much of the room is left out.
  const std::uint64_t table = codec::rate_table_bytes(shares.points);
  if (kTableShare * table > room || room - table < archive.least_bytes()) shares.points = 0;
  room -= codec::rate_table_bytes(shares.points);
  shares.signals = std::min(shares.signals, room / kSignalShare);
  // The base stays, whatever the share of the attributes.
  shares.geometry =
      std::max(std::min(shares.geometry, room - shares.signals), archive.least_bytes());
  // What the geometry does not need goes to the signals.
  shares.signals = std::min<std::uint64_t>(header.signal_bytes, room - shares.geometry);
  return shares;
}

/// Points a factor of sqrt(2) in bytes from each other, from the longest prefix down; fewest bytes
/// first.
std::vector<codec::RatePoint> measure_points(RateMeter& meter, std::uint64_t least,
                                             std::uint64_t most, Progress& progress) {
  std::vector<codec::RatePoint> points;
  auto bytes = static_cast<double>(most);
  for (unsigned i = 0; i < kRatePoints && bytes >= double(least); ++i) {
    const auto prefix = static_cast<std::uint64_t>(bytes);
    points.push_back({narrow<std::uint32_t>(prefix), static_cast<float>(meter.psnr_at(prefix))});
    progress.advance(double(i + 1) / kRatePoints);
    bytes /= std::sqrt(2.0);
  }
  std::reverse(points.begin(), points.end());
  return points;
}

void write_file(const std::filesystem::path& path, const store::Bytes& bytes) {
  ByteSink sink(path);
  sink.write(bytes.data(), bytes.size());
  sink.commit();
}

ArchiveSummary summarise(const codec::Archive& archive, std::uint64_t bytes) {
  ArchiveSummary summary;
  summary.bytes = bytes;
  summary.header = archive.header();
  summary.least_bytes = archive.least_bytes();
  summary.complete = archive.complete();
  summary.complete_bytes = archive.complete_bytes();
  summary.signals = archive.signals();
  summary.points = archive.rate_points();
  summary.faces = std::uint64_t{summary.header.base_faces} << (2 * summary.header.levels);
  return summary;
}

/// An archive in memory, and once more the code of it that is decoded.
struct ArchiveBytes {
  Reservation memory;
  store::Bytes bytes;
};

ArchiveBytes read_archive(const std::filesystem::path& path, MemoryBudget& budget) {
  const store::File file = store::File::open_read(path);
  const std::uint64_t size = file.size();
  ArchiveBytes archive{budget.reserve(2 * size, "the archive"), {}};
  archive.bytes.resize(static_cast<std::size_t>(size));
  file.read_at(0, archive.bytes);
  return archive;
}

}  // namespace

unsigned choose_level(std::uint64_t input_faces, std::uint64_t base_faces,
                      std::uint64_t memory_bytes) {
  const double wanted = kFacesPerInputFace * double(input_faces) / double(base_faces);
  const double level = std::round(0.5 * std::log2(std::max(wanted, 1.0)));
  auto result = static_cast<unsigned>(std::min(level, double(kFinestChosen)));
  const auto needs = [&](unsigned j) {
    return (base_faces << (2 * j)) / 2 * kCodingBytesPerVertex;
  };
  while (result > 0 && needs(result) > memory_bytes) --result;
  return result;
}

ArchiveSummary encode_file(const EncodeOptions& options, Progress& progress) {
  const unsigned threads =
      options.threads != 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  MemoryBudget budget(options.memory_bytes);
  const std::unique_ptr<CodedSurface> surface =
      open_coded_surface({options.input, options.level, options.attributes, options.memory_bytes,
                          threads, options.temp_dir, options.samples},
                         budget, progress);
  progress.begin("encode");
  const store::Bytes bytes =
      codec::encode_mesh(surface->release_mesh(),
                         {options.wavelet, std::max(options.bitplanes, 1u),
                          std::max(options.attribute_bitplanes, 1u), &progress},
                         budget);
  const codec::Archive archive(bytes, options.archive);
  const Shares shares = share_out(archive, options);
  std::uint64_t geometry = shares.geometry;
  std::vector<codec::RatePoint> points;
  if (options.measure || options.target_psnr) {
    progress.begin("measure");
    RateMeter meter(archive, *surface, budget);
    if (options.target_psnr) {
      geometry =
          reach_target(meter, *options.target_psnr, archive.least_bytes(), geometry, progress);
    }
    if (shares.points > 0)
      points = measure_points(meter, archive.least_bytes(), geometry, progress);
  }
  const store::Bytes sealed = codec::seal_archive(archive, geometry, shares.signals, points);
  write_file(options.archive, sealed);
  return summarise(codec::Archive(sealed, options.archive), sealed.size());
}

DecodeSummary decode_file(const DecodeOptions& options, Progress& progress) {
  MemoryBudget budget(options.memory_bytes);
  const auto [memory, bytes] = read_archive(options.archive, budget);
  const codec::Archive archive(bytes, options.archive);
  const codec::ArchiveHeader& header = archive.header();
  if (options.level && *options.level > header.levels) {
    throw InputError(fmt::format("{}: level {} is asked for, but its finest is {}",
                                 options.archive.string(), *options.level, header.levels));
  }
  std::uint64_t prefix = bytes.size();
  if (options.psnr) {
    const auto& points = archive.rate_points();
    const auto enough = std::find_if(points.begin(), points.end(),
                                     [&](const auto& p) { return p.psnr_db >= *options.psnr; });
    if (points.empty()) {
      throw InputError(options.archive.string() +
                       ": it has no rate-distortion table to look --psnr up in; use --bytes");
    }
    if (enough == points.end()) {
      throw InputError(fmt::format("{}: --psnr {:.2f}: its best is {:.2f} dB",
                                   options.archive.string(), *options.psnr, points.back().psnr_db));
    }
    prefix = enough->bytes;
  }
  if (options.bytes) prefix = std::min(prefix, *options.bytes);
  progress.begin("decode");
  const codec::SemiRegularMesh mesh =
      archive.decode(prefix, options.level.value_or(header.levels), budget);
  progress.begin("write");
  DecodeSummary summary;
  summary.bytes = prefix;
  summary.level = mesh.levels;
  summary.vertices = mesh.position.size();
  summary.faces = std::uint64_t{mesh.base.size()} << (2 * mesh.levels);
  write_mesh(mesh, options.output, budget, progress);
  return summary;
}

ArchiveSummary summarise_archive(const std::filesystem::path& path) {
  MemoryBudget budget(kSummaryBytes);
  const auto [memory, bytes] = read_archive(path, budget);
  return summarise(codec::Archive(bytes, path), bytes.size());
}

bool is_archive(const std::filesystem::path& path) {
  std::array<char, 8> start{};
  std::ifstream file(path, std::ios::binary);
  return file.read(start.data(), start.size()) &&
         std::memcmp(start.data(), "remapsGA", start.size()) == 0;
}

}  // namespace remaps::pipeline
