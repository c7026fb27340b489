#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/domain_level.h"
#include "remaps/repair/orientation_join.h"
#include "remaps/repair/segment_analysis.h"
#include "remaps/store/bucket_file.h"

namespace remaps::repair {

struct RepairOptions {
  EdgeRule rule = EdgeRule::kPair;
  std::uint64_t min_component = 0;  ///< faces; smaller components are dropped
  unsigned threads = 1;
  std::uint64_t buffer_bytes = 0;  ///< for what segments tell each other
  std::filesystem::path temp_dir;
  Progress* progress = nullptr;  ///< optional
};

struct Findings {
  Defects defects;
  DefectPlaces places;
  /// Where the surface has one side only: it cannot be oriented. Empty if it can.
  std::string one_sided;
};

/// What was done, in numbers.
struct RepairCounts {
  std::uint64_t dropped_duplicates = 0;
  std::uint64_t flipped_faces = 0;
  std::uint64_t split_vertices = 0;  ///< copies made
  std::uint64_t dropped_components = 0, dropped_component_faces = 0;
};

/// Makes a manifold of the first level, segment by segment and in two passes:
/// docs/design/repair.md.
class LevelRepair {
 public:
  LevelRepair(DomainLevel& level, const RepairOptions& options, MemoryBudget& budget);

  ~LevelRepair();

  /// Looks at all segments, and leaves the level as it is.
  Findings inspect();

  /// Writes the repaired surface to `out`, which has the same cut, and frees the level. After
  /// inspect, which must have found it orientable. Copies of vertices get the numbers from
  /// `first_copy` on.
  /// @param copied  hears in this order which vertices they are copies of
  RepairCounts rewrite(DomainLevel& out, VertexId first_copy,
                       FunctionRef<void(std::span<const VertexId>)> copied);

 private:
  struct Lane;
  struct Inspected;
  struct Rewritten;

  /// What is decided of one component of a segment.
  struct Decision {
    bool turn = false;  ///< those that run like its first face, else the others
    bool drop = false;
    bool shared = false;
  };

  std::shared_ptr<Inspected> inspect_segment(std::size_t i, Lane& lane);
  void note(Inspected& part);
  std::shared_ptr<Rewritten> rewrite_segment(std::size_t i, Lane& lane, VertexId first_copy);
  std::vector<Decision> decide(std::size_t i, const Lane& lane);
  void apply_notes(std::size_t i, Lane& lane, VertexId first_copy);
  void report(std::size_t i, double from, double to) const;

  DomainLevel& level_;
  RepairOptions options_;
  std::vector<Lane> lanes_;
  OrientationJoin join_;
  store::BucketFile notes_;  // copied corners of faces that are at home elsewhere, by home
  Reservation reservation_;
  std::vector<std::uint32_t> first_part_;  // (segments)
  std::vector<std::uint64_t> first_copy_;  // (segments) copies in those before
  Findings findings_;
  std::uint64_t copies_ = 0;
};

}  // namespace remaps::repair
