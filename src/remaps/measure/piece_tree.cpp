#include "remaps/measure/piece_tree.h"

#include "remaps/mesh/point_triangle.h"

namespace remaps {

void PieceTree::build(const SurfacePiece& piece, double scale) {
  piece_ = &piece;
  Box3 box;
  for (const Vec3& p : piece.position) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  frame_ = FloatFrame(0.5 * box.low + 0.5 * box.high, scale);
  local_.clear();
  for (const Vec3& p : piece.position) local_.push_back(frame_.to_local(p));
  triangle_.clear();
  for (const auto& t : piece.triangle) {
    const Float3 a = local_[t[0]], b = local_[t[1]], c = local_[t[2]];
    triangle_.push_back({{std::min(std::min(a.x, b.x), c.x), std::min(std::min(a.y, b.y), c.y),
                          std::min(std::min(a.z, b.z), c.z)},
                         {std::max(std::max(a.x, b.x), c.x), std::max(std::max(a.y, b.y), c.y),
                          std::max(std::max(a.z, b.z), c.z)}});
  }
  boxes_.build(triangle_);
  spread_ = spread_of(boxes_.box());
}

double PieceTree::distance2(const Vec3& p, std::uint32_t triangle) const {
  return closest_point_on_triangle(p, piece_->corners(triangle)).distance2;
}

}  // namespace remaps
