#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/face_labels.h"
#include "remaps/mesh/topology.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/repair_input.h"
#include "remaps/pipeline/report.h"

namespace remaps::pipeline {

struct ParameterizeJob {
  std::filesystem::path input;
  std::filesystem::path bundle;    ///< an empty directory: filled, the manifest last
  std::filesystem::path temp_dir;  ///< an empty directory for everything else
  std::uint64_t base_vertices = 200;
  unsigned threads = 1;
  bool strict = false;  ///< refuse what would need repair
  RepairChoices repair;
  std::optional<double> weld_distance;  ///< in file units: docs/design/weld.md
  double feature_angle_deg = 0;         ///< 0: none by angle
  FaceLabelChoice feature_labels;       ///< features lie between faces that differ in these
  bool write_map = true;  ///< false: without map.bin, for a bundle that only serves to resample
  AttributeChoice attributes;  ///< that the bundle keeps
  /// Called when the first sweep has counted the surface; may refuse it by an exception.
  std::function<void(const Topology&)> accept;
};

/// Ingest, sweeps, map: from a mesh file to a sealed bundle. Fills the report's parts on input,
/// repairs, base, sweeps and the seconds of these phases. Source: [AGL06] sections 3 and 4.
void parameterize(const ParameterizeJob& job, const MemoryPlan& plan, MemoryBudget& budget,
                  Progress& progress, Report& report);

}  // namespace remaps::pipeline
