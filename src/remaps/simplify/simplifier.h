#pragma once

#include <vector>

#include "remaps/mesh/patch.h"
#include "remaps/mesh/retriangulation.h"
#include "remaps/mesh/segment.h"
#include "remaps/simplify/removal.h"
#include "remaps/simplify/removal_queue.h"

namespace remaps::simplify {

/// Simplifies one segment at a time by vertex removal and writes the log. Keeps its buffers from
/// one to the next.
class Simplifier {
 public:
  /// Removes unlocked vertices, cheapest first, until target_vertices are left or none can go.
  ///
  /// @param segment  triangle is out of date afterwards: read the faces from patch; load and
  /// quadric are kept up
  /// @param alive    number of own vertices that have faces
  /// @param log      records are appended
  /// @param removed  the removed vertices are appended, one a record
  /// @return  number of own vertices left
  /// Cost: about 1.5 evaluations of a star per removal and a logarithmic queue operation each.
  std::size_t run(const SimplifyOptions& options, Segment& segment, Patch& patch, std::size_t alive,
                  RetriangulationLog& log, std::vector<LocalIndex>& removed);

 private:
  struct Candidate {
    bool valid = false;
    unsigned apex = 0;
    float cost = 0;
  };

  enum class Care { kCareful, kThorough };

  bool load_star(LocalIndex v);
  bool flatten();
  Candidate evaluate(LocalIndex v, Care care);
  unsigned rank_fans(LocalIndex v, std::array<unsigned, kMaxRing>& order) const;
  bool fan_fits(unsigned apex) const;
  double fan_cost(LocalIndex v, unsigned apex);
  double fan_shape(unsigned apex) const;
  void refresh(LocalIndex v, Care care);
  void update_ring(float cost);
  void remove(LocalIndex v, unsigned apex, RetriangulationLog& log);

  const SimplifyOptions* options_ = nullptr;
  Segment* segment_ = nullptr;
  Patch* patch_ = nullptr;
  Care care_ = Care::kCareful;
  RemovalQueue queue_;
  std::vector<std::uint8_t> stale_;
  std::vector<std::uint8_t> apex_;

  // The star in hand.
  Star star_;
  Crease crease_;
  FlatStar flat_;
  std::array<Vec3, kMaxRing> offset_{};
  std::array<Vec3, kMaxStarFaces> normal_{};  // doubled, of the wedges
  std::array<float, kMaxStarFaces> wedge_load_{};
  double star_load_ = 0;
  std::array<double, kMaxRing> fan_load_{};
};

}  // namespace remaps::simplify
