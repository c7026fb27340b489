#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "remaps/base/progress.h"
#include "remaps/codec/archive.h"
#include "remaps/mesh/attributes.h"

namespace remaps::pipeline {

struct EncodeOptions {
  std::filesystem::path input;    ///< bundle, or a mesh with subdivision connectivity
  std::filesystem::path archive;  ///< appears under this name when all is well
  std::optional<unsigned> level;  ///< of the mesh that is coded; by default choose_level's of a
                                  ///< bundle, all that there are of a mesh
  codec::Wavelet wavelet = codec::Wavelet::kLiftedButterfly;
  unsigned bitplanes = 12;
  unsigned attribute_bitplanes = codec::kSignalPlanes;
  /// Colours and normals of vertices that are coded; by default colours only, since normals follow
  /// from the surface.
  std::optional<AttributeChoice> attributes;
  std::optional<std::uint64_t> max_bytes;  ///< of the archive; attributes get a third of them
  std::optional<double> target_psnr;       ///< dB; the archive is no longer than it takes
  bool measure = true;                     ///< makes the rate-distortion table
  std::uint64_t samples = 200'000;         ///< a measurement
  std::uint64_t memory_bytes = 256 << 20;
  unsigned threads = 0;            ///< 0: as many as there are cores
  std::filesystem::path temp_dir;  ///< empty: the system's
};

/// What an archive has in it.
struct ArchiveSummary {
  std::uint64_t bytes = 0;
  codec::ArchiveHeader header;
  std::uint64_t least_bytes = 0;
  std::uint64_t complete_bytes = 0;  ///< of the file, if all of it is there
  bool complete = true;
  std::vector<codec::SignalHeader> signals;
  std::vector<codec::RatePoint> points;
  std::uint64_t faces = 0;  ///< of the finest level
};

/// The level of a bundle's mesh that is coded if none is asked for: the one whose number of faces
/// is nearest to 12 times the input's, since fine details cost next to nothing where they are
/// small, and at most so fine that coding it fits the memory.
unsigned choose_level(std::uint64_t input_faces, std::uint64_t base_faces,
                      std::uint64_t memory_bytes);

/// Codes the semi-regular mesh of a bundle, or any mesh with subdivision connectivity.
///
/// The distortion is measured against the input surface of the bundle; of a mesh, against itself.
/// @throws InputError     unreadable; GeometryError: no subdivision connectivity
/// @throws BudgetError    does not fit memory_bytes, or max_bytes is less than the base mesh takes
/// @throws GeometryError  the target is out of reach at this level and number of bitplanes
ArchiveSummary encode_file(const EncodeOptions& options, Progress& progress);

struct DecodeOptions {
  std::filesystem::path archive;       ///< or the beginning of one
  std::filesystem::path output;        ///< mesh
  std::optional<std::uint64_t> bytes;  ///< no more than these of the archive
  std::optional<unsigned> level;       ///< of the output
  std::optional<double> psnr;  ///< dB; as many bytes as the archive's table says that it takes
  std::uint64_t memory_bytes = 256 << 20;
};

struct DecodeSummary {
  std::uint64_t bytes = 0;  ///< of the archive that were used
  unsigned level = 0;
  std::uint64_t vertices = 0, faces = 0;
};

/// Decodes an archive to a mesh file, in the numbering of docs/formats/semi-regular.md.
DecodeSummary decode_file(const DecodeOptions& options, Progress& progress);

/// @throws InputError, CorruptionError  as codec::Archive does
ArchiveSummary summarise_archive(const std::filesystem::path& path);
/// Whether a file begins as archives do.
bool is_archive(const std::filesystem::path& path);

}  // namespace remaps::pipeline
