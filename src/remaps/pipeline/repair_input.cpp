#include "remaps/pipeline/repair_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "remaps/mesh/vertex_copies.h"
#include "remaps/repair/hole_filler.h"

namespace remaps::pipeline {

Reservation reserve_lanes(const DomainLevel& level, const MemoryPlan& plan, MemoryBudget& budget) {
  const std::uint64_t faces = level.largest_segment();
  const auto lanes = std::min<std::uint64_t>(plan.sweep_threads, level.segments());
  const std::uint64_t face_bytes = kBytesPerFace + (level.has_labels() ? sizeof(FaceLabel) : 0);
  return budget.reserve(faces * face_bytes * (lanes + (lanes > 1 ? 1 : 0)),
                        fmt::format("working on segments of up to {} faces", faces));
}

namespace {

/// Notes what copies of vertices are made of; a copy of a copy is one of the latter's original.
void note_originals(Ingested& ingested, std::span<const VertexId> originals,
                    const std::filesystem::path& temp_dir) {
  if (originals.empty()) return;
  if (ingested.originals == nullptr) {
    ingested.originals =
        std::make_unique<store::RowSpool>(temp_dir / "copied-vertices", sizeof(VertexId));
  }
  std::vector<VertexId> resolved(originals.begin(), originals.end());
  for (VertexId& v : resolved) {
    if (v == kNoVertex || v < ingested.vertices) continue;
    const std::uint64_t copy = v - ingested.vertices;
    ingested.originals->read(copy, std::as_writable_bytes(std::span(&v, 1)));
  }
  ingested.originals->append(std::as_bytes(std::span(resolved)));
}

/// Puts a repaired level in the place of the ingested one.
/// @param sound  leave it as it is if nothing is wrong with it
repair::Findings repair_once(Ingested& ingested, repair::RepairOptions options, bool sound,
                             const MemoryPlan& plan, MemoryBudget& budget, Repairs& repairs) {
  DomainLevel& level = *ingested.level;
  std::filesystem::create_directory(options.temp_dir);
  const Reservation lanes = reserve_lanes(level, plan, budget);
  repair::LevelRepair repair(level, options, budget);
  const repair::Findings found = repair.inspect();
  if (!found.one_sided.empty() || (sound && !found.defects.any())) return found;
  auto repaired =
      std::make_unique<DomainLevel>(0, level.cut(), options.temp_dir, plan.bucket_bytes, budget);
  if (level.has_labels()) repaired->carry_labels();
  const repair::RepairCounts counts =
      repair.rewrite(*repaired, ingested.vertices + ingested.copied_vertices,
                     [&](std::span<const VertexId> originals) {
                       note_originals(ingested, originals, options.temp_dir.parent_path());
                     });
  ingested.level = std::move(repaired);
  ingested.copied_vertices += counts.split_vertices;
  repairs.nonmanifold_vertices += found.defects.nonmanifold_vertices;
  repairs.duplicate_faces += counts.dropped_duplicates;
  repairs.flipped_faces += counts.flipped_faces;
  repairs.split_vertices += counts.split_vertices;
  repairs.dropped_components += counts.dropped_components;
  repairs.dropped_component_faces += counts.dropped_component_faces;
  return found;
}

repair::Findings make_manifold(Ingested& ingested, repair::RepairOptions options,
                               const MemoryPlan& plan, const std::filesystem::path& temp_dir,
                               MemoryBudget& budget, Repairs& repairs) {
  options.temp_dir = temp_dir / "repair-1";
  repair::Findings found;
  {
    const ProgressPart part(options.progress, 0, 0.7);
    found = repair_once(ingested, options, false, plan, budget, repairs);
  }
  repairs.nonmanifold_edges = found.defects.nonmanifold_edges;
  if (found.defects.nonmanifold_edges == 0) return found;
  // Pairs of faces may still share an edge at both of its ends; and faces that were paired where
  // orientations were wrong may make a surface that cannot be oriented, so that nothing was done.
  options.rule = repair::EdgeRule::kCut;
  options.temp_dir = temp_dir / "repair-2";
  const ProgressPart part(options.progress, 0.7, 1);
  found.one_sided =
      repair_once(ingested, options, found.one_sided.empty(), plan, budget, repairs).one_sided;
  return found;
}

void fill(Ingested& ingested, std::uint64_t most_edges, const MemoryPlan& plan,
          const std::filesystem::path& temp_dir, MemoryBudget& budget, Progress& progress,
          Repairs& repairs) {
  const Reservation lanes = reserve_lanes(*ingested.level, plan, budget);
  const repair::FillCounts counts =
      repair::fill_holes(*ingested.level, {most_edges, plan.sweep_threads, &progress},
                         ingested.faces, ingested.vertices + ingested.copied_vertices, budget);
  ingested.filled_faces = counts.faces;
  ingested.copied_vertices += counts.vertices;
  constexpr std::uint64_t kChunk = 1 << 10;
  for (std::uint64_t done = 0; done < counts.vertices; done += kChunk) {
    const std::vector<VertexId> none(
        static_cast<std::size_t>(std::min(kChunk, counts.vertices - done)), kNoVertex);
    note_originals(ingested, none, temp_dir);
  }
  repairs.filled_holes = counts.holes;
  repairs.filled_faces = counts.faces;
}

}  // namespace

repair::Findings repair_input(Ingested& ingested, const RepairChoices& choices,
                              const MemoryPlan& plan, const std::filesystem::path& temp_dir,
                              MemoryBudget& budget, Progress& progress, Repairs& repairs) {
  progress.begin("repair");
  repair::RepairOptions options;
  options.min_component = choices.min_component;
  options.threads = plan.sweep_threads;
  options.buffer_bytes = plan.bucket_bytes / 4;
  options.progress = &progress;
  const double filling = choices.fill_holes > 0 ? 0.2 : 0.0;
  repair::Findings found;
  {
    const ProgressPart part(&progress, 0, 1 - filling);
    found = make_manifold(ingested, options, plan, temp_dir, budget, repairs);
  }
  if (found.one_sided.empty() && choices.fill_holes > 0) {
    const ProgressPart part(&progress, 1 - filling, 1);
    fill(ingested, choices.fill_holes, plan, temp_dir, budget, progress, repairs);
  }
  return found;
}

}  // namespace remaps::pipeline
