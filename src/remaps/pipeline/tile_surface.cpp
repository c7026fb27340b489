#include "remaps/pipeline/tile_surface.h"

#include <algorithm>
#include <string>
#include <vector>

#include "remaps/base/workers.h"
#include "remaps/mesh/segment_log.h"

namespace remaps::pipeline {
namespace {

struct Lane {
  store::Bytes bytes;
  Tile tile;
  SurfacePiece piece;
};

}  // namespace

TriangleSource triangles_of_tiles(const store::SectionFile& tiles) {
  return [&tiles](TriangleSink sink) {
    store::Bytes bytes;
    Tile tile;
    std::vector<TrianglePositions> triangles;
    for (std::size_t i = 0; i < tiles.sections(); ++i) {
      tiles.read(i, bytes);
      decode_tile(bytes, tiles.path().string() + ": tile " + std::to_string(i), tile);
      triangles.clear();
      for (const auto& t : tile.triangle) {
        triangles.push_back(
            {widen(tile.position[t[0]]), widen(tile.position[t[1]]), widen(tile.position[t[2]])});
      }
      sink(triangles);
    }
  };
}

void TilePieces::stream(unsigned threads, FunctionRef<bool(std::size_t piece)> wanted,
                        const Work& work) const {
  std::vector<Lane> lanes(std::max(threads, 1u));
  run_ordered(tiles_.sections(), threads, [&](std::size_t i, unsigned number) -> Commit {
    if (!wanted(i)) return [] {};
    Lane& lane = lanes[number];
    tiles_.read(i, lane.bytes);
    decode_tile_surface(lane.bytes, tiles_.path().string() + ": tile " + std::to_string(i),
                        lane.tile);
    lane.piece.clear();
    for (const Vec3f& p : lane.tile.position) lane.piece.position.push_back(widen(p));
    lane.piece.triangle.swap(lane.tile.triangle);
    return work(i, lane.piece, number);
  });
}

}  // namespace remaps::pipeline
