#pragma once

#include <array>
#include <vector>

#include "remaps/mesh/patch.h"
#include "remaps/mesh/retriangulation.h"
#include "remaps/mesh/segment.h"
#include "remaps/simplify/bucket_queue.h"
#include "remaps/simplify/removal.h"

namespace remaps::simplify {

/// Simplifies one segment at a time like Simplifier, several times faster and with less care for
/// the order of removal: for the early sweeps, which leave far more vertices than the base has.
///
/// Each vertex has an estimate of its cost, kept up by arithmetic on what is at hand: the least
/// quadric error along its edges as it was at the start, the sum of the loads of its star, and the
/// growth of a load spread evenly. Its star is looked at when it comes up: then the fans are
/// tried, and it is removed, or waits for its turn if the true cost is more. The loads of the new
/// triangles are those of the mean density of the star. Keys are logarithms in eighths of an
/// octave. Every rule for what may be removed is Simplifier's.
class DraftSimplifier {
 public:
  /// Parameters as for Simplifier::run.
  /// Cost: about 1.2 looks at a star per removal and a few constant-time queue operations.
  std::size_t run(const SimplifyOptions& options, Segment& segment, Patch& patch, std::size_t alive,
                  RetriangulationLog& log, std::vector<LocalIndex>& removed);

 private:
  struct Choice {
    bool valid = false;
    unsigned apex = 0;
    std::int32_t key = 0;
  };

  void estimate_all();
  std::int32_t estimated_key(LocalIndex v) const;
  bool removable(LocalIndex v) const;
  bool load_star(LocalIndex v);
  void find_fan_errors(LocalIndex v);
  float fan_shape(unsigned apex) const;
  bool valence_fits(unsigned apex) const;
  Choice choose_fan(std::int32_t limit);
  void remove(LocalIndex v, unsigned apex, RetriangulationLog& log);
  void spread_loads(unsigned apex);
  void update_ring(unsigned apex);

  const SimplifyOptions* options_ = nullptr;
  Segment* segment_ = nullptr;
  Patch* patch_ = nullptr;
  BucketQueue queue_;
  std::vector<float> fan_error_;  // (own) least quadric error at a neighbour, as far as known
  std::vector<float> star_sum_;   // (own) sum of the loads of the star

  // The star in hand.
  Star star_;
  Crease crease_;
  FlatStar flat_;
  bool flattened_ = false;
  bool flat_is_valid_ = false;
  RingOffsets offset_;
  alignas(16) RingFloats normal_x_, normal_y_, normal_z_;  // doubled, of the wedges
  alignas(16) RingFloats error_;                           // of the fan about each ring point
  std::array<float, kMaxStarFaces> wedge_load_{};
  std::array<float, kMaxRing> fan_load_{};
  float load_ = 0;
};

}  // namespace remaps::simplify
