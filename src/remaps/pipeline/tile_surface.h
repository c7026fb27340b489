#pragma once

#include "remaps/measure/surface_pieces.h"
#include "remaps/mesh/triangle_stream.h"
#include "remaps/store/section_file.h"

namespace remaps::pipeline {

/// The input surface from the tiles of a bundle, in order of place, relative to its origin.
/// @param tiles  must outlive this
TriangleSource triangles_of_tiles(const store::SectionFile& tiles);

/// The same, a tile a piece.
class TilePieces final : public SurfacePieces {
 public:
  /// @param tiles  must outlive this
  explicit TilePieces(const store::SectionFile& tiles) : tiles_(tiles) {}

  void stream(unsigned threads, FunctionRef<bool(std::size_t piece)> wanted,
              const Work& work) const override;

 private:
  const store::SectionFile& tiles_;
};

}  // namespace remaps::pipeline
