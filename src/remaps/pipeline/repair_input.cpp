#include "remaps/pipeline/repair_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace remaps::pipeline {

Reservation reserve_lanes(const DomainLevel& level, const MemoryPlan& plan, MemoryBudget& budget) {
  const std::uint64_t faces = level.largest_segment();
  const auto lanes = std::min<std::uint64_t>(plan.sweep_threads, level.segments());
  return budget.reserve(faces * kBytesPerFace * (lanes + (lanes > 1 ? 1 : 0)),
                        fmt::format("working on segments of up to {} faces", faces));
}

repair::Findings repair_input(Ingested& ingested, std::uint64_t min_component,
                              const MemoryPlan& plan, const std::filesystem::path& temp_dir,
                              MemoryBudget& budget, Progress& progress, Repairs& repairs) {
  progress.begin("repair");
  DomainLevel& level = *ingested.level;
  const std::filesystem::path directory = temp_dir / "repaired";
  std::filesystem::create_directory(directory);
  repair::RepairOptions options;
  options.min_component = min_component;
  options.threads = plan.sweep_threads;
  options.buffer_bytes = plan.bucket_bytes / 4;
  options.temp_dir = temp_dir;
  options.progress = &progress;
  const Reservation lanes = reserve_lanes(level, plan, budget);
  repair::LevelRepair repair(level, options, budget);
  repair::Findings found = repair.inspect();
  repairs.nonmanifold_edges = found.defects.nonmanifold_edges;
  repairs.nonmanifold_vertices = found.defects.nonmanifold_vertices;
  if (!found.one_sided.empty()) return found;

  auto sound = std::make_unique<DomainLevel>(0, level.cut(), directory, plan.bucket_bytes, budget);
  const repair::RepairCounts counts = repair.rewrite(*sound, ingested.vertices);
  ingested.level = std::move(sound);
  ingested.copied_vertices = counts.split_vertices;
  repairs.duplicate_faces = counts.dropped_duplicates;
  repairs.flipped_faces = counts.flipped_faces;
  repairs.split_vertices = counts.split_vertices;
  repairs.dropped_components = counts.dropped_components;
  repairs.dropped_component_faces = counts.dropped_component_faces;
  return found;
}

}  // namespace remaps::pipeline
