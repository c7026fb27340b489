#include "remaps/mesh/retriangulation.h"

namespace remaps {

double orientation_near_zero(GridPoint a, GridPoint b, PlanarPoint p) {
  __extension__ using Quad = __float128;
  const Quad x = p.x;
  const Quad y = p.y;
  return static_cast<double>((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x));
}

bool RetriangulationLog::assign(std::vector<std::uint32_t> words) {
  clear();
  words_ = std::move(words);
  std::size_t at = 0;
  while (at < words_.size()) {
    const unsigned k = words_[at] & 15u;
    const bool at_boundary = (words_[at] & 16u) != 0;
    const unsigned n = k + (at_boundary ? 1u : 0u);
    const std::size_t length = std::size_t{2} + k + n;
    const bool sound = n >= 3 && k <= kMaxStarFaces && (words_[at] & ~0xF1Fu) == 0 &&
                       ((words_[at] >> 8) & 15u) < n && length <= words_.size() - at;
    if (!sound) {
      clear();
      return false;
    }
    starts_.push_back(static_cast<std::uint32_t>(at));
    at += length;
  }
  return true;
}

}  // namespace remaps
