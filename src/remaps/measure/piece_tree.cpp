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
  const Float3 low = frame_.to_local(box.low), high = frame_.to_local(box.high);
  local_.clear();
  for (const Vec3& p : piece.position) local_.push_back(frame_.to_local(p));
  boxes_.build(static_cast<std::uint32_t>(piece.triangle.size()), {low, high},
               [&](std::uint32_t i) -> FloatBox {
                 const auto& t = piece.triangle[i];
                 const Float4 a = local_[t[0]].all(), b = local_[t[1]].all(),
                              c = local_[t[2]].all();
                 return {Float3::of(min4(min4(a, b), c)), Float3::of(max4(max4(a, b), c))};
               });
  spread_ = spread_of(boxes_.box());
}

double PieceTree::distance2(const Vec3& p, std::uint32_t triangle) const {
  const auto& t = piece_->triangle[triangle];
  const std::vector<Vec3>& position = piece_->position;
  return triangle_distance2(p, position[t[0]], position[t[1]], position[t[2]]);
}

}  // namespace remaps
