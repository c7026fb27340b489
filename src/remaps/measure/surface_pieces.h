#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"
#include "remaps/base/workers.h"
#include "remaps/mesh/triangle_stream.h"

namespace remaps {

/// Some triangles of a surface.
struct SurfacePiece {
  std::vector<Vec3> position;                       ///< may hold some that no triangle uses
  std::vector<std::array<LocalIndex, 3>> triangle;  ///< into `position`

  TrianglePositions corners(std::size_t i) const {
    return {position[triangle[i][0]], position[triangle[i][1]], position[triangle[i][2]]};
  }
  void clear() {
    position.clear();
    triangle.clear();
  }
};

/// A surface in pieces, which are the same ones each time it is streamed. The surface as a whole
/// need not fit in memory.
class SurfacePieces {
 public:
  using Work = std::function<Commit(std::size_t piece, const SurfacePiece&, unsigned lane)>;

  virtual ~SurfacePieces() = default;

  /// Loads the pieces that are wanted and works on them, on up to `threads` threads, as run_ordered
  /// does: commits are run in the order of the pieces, one at a time.
  ///
  /// @param wanted  may be asked on any thread
  virtual void stream(unsigned threads, FunctionRef<bool(std::size_t piece)> wanted,
                      const Work& work) const = 0;
};

/// A stream of triangles as pieces: each the next so many, whatever the chunks of the stream.
///
/// The stream itself is read by one thread; while pieces are worked on, it waits.
class StreamedPieces final : public SurfacePieces {
 public:
  /// @param triangles     must outlive this
  /// @param memory_bytes  of the job: pieces are larger where there is more. That makes measuring
  ///                      faster if the stream isn't coherent in space
  StreamedPieces(const TriangleSource& triangles, std::uint64_t memory_bytes);

  void stream(unsigned threads, FunctionRef<bool(std::size_t piece)> wanted,
              const Work& work) const override;

 private:
  const TriangleSource& triangles_;
  const std::size_t piece_triangles_;
};

}  // namespace remaps
