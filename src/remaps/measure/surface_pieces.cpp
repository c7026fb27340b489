#include "remaps/measure/surface_pieces.h"

#include <algorithm>
#include <span>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

void append(SurfacePiece& piece, std::span<const TrianglePositions> triangles) {
  for (const TrianglePositions& corners : triangles) {
    const auto first = narrow<LocalIndex>(piece.position.size());
    piece.position.insert(piece.position.end(), corners.begin(), corners.end());
    piece.triangle.push_back({first, first + 1, first + 2});
  }
}

/// A piece and its tree in each lane, as a share of the memory of a job.
constexpr std::uint64_t kBytesPerTriangle = 16 * 256;

}  // namespace

StreamedPieces::StreamedPieces(const TriangleSource& triangles, std::uint64_t memory_bytes)
    : triangles_(triangles),
      piece_triangles_(static_cast<std::size_t>(
          std::clamp<std::uint64_t>(memory_bytes / kBytesPerTriangle, 256, 1 << 16))) {}

void StreamedPieces::stream(unsigned threads, FunctionRef<bool(std::size_t piece)> wanted,
                            const Work& work) const {
  std::vector<SurfacePiece> batch(std::max(threads, 1u));
  std::size_t done = 0;  // pieces before the batch
  std::size_t full = 0;  // pieces of the batch
  const auto work_on_batch = [&] {
    run_ordered(full, threads, [&](std::size_t i, unsigned lane) -> Commit {
      if (!wanted(done + i)) return [] {};
      return work(done + i, batch[i], lane);
    });
    for (SurfacePiece& piece : batch) piece.clear();
    done += full;
    full = 0;
  };
  triangles_([&](std::span<const TrianglePositions> chunk) {
    while (!chunk.empty()) {
      SurfacePiece& piece = batch[full];
      const std::size_t n = std::min(chunk.size(), piece_triangles_ - piece.triangle.size());
      append(piece, chunk.first(n));
      chunk = chunk.subspan(n);
      if (piece.triangle.size() == piece_triangles_ && ++full == batch.size()) work_on_batch();
    }
  });
  if (!batch[full].triangle.empty()) ++full;
  if (full > 0) work_on_batch();
}

}  // namespace remaps
