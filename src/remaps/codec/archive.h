#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/codec/base_code.h"
#include "remaps/codec/geometry_code.h"
#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/store/packing.h"

namespace remaps::codec {

/// A mesh with subdivision connectivity, in the numbering of SubdivisionHierarchy.
struct SemiRegularMesh {
  std::uint32_t base_vertices = 0;
  std::vector<Face> base;
  unsigned levels = 0;
  std::vector<Vec3> position;  ///< (vertices of the finest level)
};

struct EncodeOptions {
  Wavelet wavelet = Wavelet::kLiftedButterfly;
  unsigned bitplanes = 12;  ///< 1 to 30: of the largest detail
  Progress* progress = nullptr;
};

/// A point of the rate-distortion curve.
struct RatePoint {
  std::uint32_t bytes = 0;  ///< of a prefix of the archive
  float psnr_db = 0;        ///< 20 log10(bounding-box diagonal / L2 error) against the original
};

/// As many as an archive can have, and what the longest table takes.
inline constexpr std::size_t kMostRatePoints = 48;
inline constexpr std::uint64_t kRateTableMostBytes = 14 * 8 + 4;

/// What stands ahead of everything in an archive. Format: docs/formats/archive.md.
struct ArchiveHeader {
  Quantization quantization;
  std::uint8_t levels = 0;
  std::uint32_t base_vertices = 0, base_faces = 0;
  std::uint32_t base_bytes = 0;      ///< of the code of the base mesh
  std::uint32_t geometry_bytes = 0;  ///< of the code of all details
  std::uint32_t rate_points = 0;
};

/// Codes a mesh: header, base, details. Every prefix of the result that holds header and base can
/// be decoded. Cost: about 140 bytes a vertex, reserved.
/// @throws GeometryError  the base is not an oriented manifold, or a position is not finite
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
  const std::vector<RatePoint>& rate_points() const { return rate_points_; }
  /// Of the file, if all of it were there.
  std::uint64_t complete_bytes() const;
  /// Of header and base: the shortest prefix that can be decoded.
  std::uint64_t least_bytes() const;
  bool complete() const { return bytes_.size() == complete_bytes(); }

  /// Decodes a mesh.
  /// @param prefix  bytes of the archive to be used; those that are there at most
  /// @param level   of the mesh: header().levels, or less for a coarser one
  /// @throws InputError   prefix is below least_bytes()
  /// @throws BudgetError  about 110 bytes a vertex do not fit
  SemiRegularMesh decode(std::uint64_t prefix, unsigned level, MemoryBudget& budget) const;

 private:
  store::ByteSpan bytes_;
  std::filesystem::path name_;
  ArchiveHeader header_;
  std::vector<RatePoint> rate_points_;
};

/// An archive cut to a number of bytes, and sealed with points of its rate-distortion curve. Its
/// prefixes are those of the given one but for the header.
/// @param archive  complete, without rate points
/// @param bytes    of the code that is kept: a prefix of archive; the points come on top
store::Bytes seal_archive(store::ByteSpan archive, std::uint64_t bytes,
                          std::span<const RatePoint> points);

}  // namespace remaps::codec
