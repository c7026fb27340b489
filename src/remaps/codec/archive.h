#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/codec/base_code.h"
#include "remaps/codec/geometry_code.h"
#include "remaps/codec/semi_regular_mesh.h"
#include "remaps/codec/signal_code.h"
#include "remaps/store/packing.h"

namespace remaps::codec {

/// Bits of a detail that a signal keeps, if not told otherwise.
inline constexpr unsigned kSignalPlanes = 7;

struct EncodeOptions {
  Wavelet wavelet = Wavelet::kLiftedButterfly;
  unsigned bitplanes = 12;                    ///< 1 to 30: of the largest detail
  unsigned signal_bitplanes = kSignalPlanes;  ///< 1 to 30: of values from -1 to 1
  Progress* progress = nullptr;
};

/// A point of the rate-distortion curve.
struct RatePoint {
  std::uint32_t bytes = 0;  ///< of a prefix of the archive
  float psnr_db = 0;        ///< 20 log10(bounding-box diagonal / L2 error) against the original
};
/// As many as an archive may have.
inline constexpr std::size_t kMostRatePoints = 48;
/// What a table of so many takes.
std::uint64_t rate_table_bytes(std::size_t points);

/// What stands ahead of everything in an archive. Format: docs/formats/archive.md.
struct ArchiveHeader {
  Wavelet wavelet = Wavelet::kLiftedButterfly;
  Quantization quantization;
  Vec3 origin;                  ///< of the grid of base vertices
  std::uint8_t grid_shift = 0;  ///< its cells have 2^grid_shift steps
  std::uint8_t levels = 0;
  std::uint32_t base_vertices = 0, base_faces = 0;
  std::uint32_t base_bytes = 0;      ///< of the code of the base mesh
  std::uint32_t geometry_bytes = 0;  ///< of the code of all details
  std::uint32_t signal_bytes = 0;    ///< of all signals, with their headers and checksums
  std::uint32_t rate_points = 0;

  BaseGrid grid() const;
};

/// Codes a mesh: header, base, details, signals. Every prefix of the result that holds header and
/// base can be decoded.
/// Cost: about 110 bytes a vertex, 30 for the connectivity and 24 a signal, reserved.
/// @throws GeometryError  the base is not an oriented manifold, or a value is not finite
/// @throws BudgetError    it does not fit
store::Bytes encode_mesh(SemiRegularMesh mesh, const EncodeOptions& options, MemoryBudget& budget);

/// An archive, or a prefix of one, open for decoding.
class Archive {
 public:
  /// Checks all that is there.
  /// @param bytes  must outlive this
  /// @param name   of the file, for messages
  /// @throws InputError       not an archive, or it ends before the base does
  /// @throws CorruptionError  a checksum fails, or a count does not fit
  Archive(store::ByteSpan bytes, std::filesystem::path name);

  const ArchiveHeader& header() const { return header_; }
  /// Those whose headers are there.
  std::vector<SignalHeader> signals() const;
  const std::vector<RatePoint>& rate_points() const { return rate_points_; }
  /// Of the file, if all of it were there.
  std::uint64_t complete_bytes() const;
  /// Of header and base: the shortest prefix that can be decoded.
  std::uint64_t least_bytes() const;
  /// Of header, base and geometry.
  std::uint64_t geometry_end() const;
  bool complete() const { return bytes_.size() == complete_bytes(); }

  /// Decodes a mesh. It has the signals whose headers are within the prefix.
  /// @param prefix  bytes of the archive to be used; those that are there at most
  /// @param level   of the mesh: header().levels, or less for a coarser one
  /// @param signals  false leaves them out
  /// @throws InputError   prefix is below least_bytes()
  /// @throws BudgetError  about 100 bytes a vertex do not fit, 24 more a signal
  SemiRegularMesh decode(std::uint64_t prefix, unsigned level, MemoryBudget& budget,
                         bool signals = true) const;

 private:
  friend store::Bytes seal_archive(const Archive&, std::uint64_t, std::uint64_t,
                                   std::span<const RatePoint>);
  struct SignalPlace {
    SignalHeader header;
    std::uint64_t offset = 0;  ///< of its first block
  };

  void find_signals();
  void check_blocks(std::uint64_t at, std::uint64_t code_bytes) const;
  void read_rate_points();

  store::ByteSpan bytes_;
  std::filesystem::path name_;
  ArchiveHeader header_;
  std::vector<SignalPlace> signals_;
  std::vector<RatePoint> rate_points_;
};

/// A complete archive cut to fewer bytes, and sealed with points of its rate-distortion curve.
/// @param geometry  bytes that header, base and geometry keep, 0 or more; the base always stays
/// @param signals   bytes that all signals keep together, in equal parts of what they have
store::Bytes seal_archive(const Archive& archive, std::uint64_t geometry, std::uint64_t signals,
                          std::span<const RatePoint> points);

}  // namespace remaps::codec
