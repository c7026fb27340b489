#include "remaps/pipeline/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/base/workers.h"
#include "remaps/pipeline/disk_plan.h"
#include "remaps/pipeline/ingest.h"
#include "remaps/pipeline/input_mesh.h"
#include "remaps/pipeline/repair_input.h"
#include "remaps/pipeline/run_plan.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

struct Lane {
  VertexIndex index;
  Segment segment;
  std::vector<FaceLink> origin;
  Patch patch;
};

struct Counted {
  SegmentTopology topology;
  std::uint64_t unreferenced = 0;
};

std::shared_ptr<Counted> count(DomainLevel& level, std::size_t i, Lane& lane) {
  level.load(i, lane.index, lane.segment, lane.origin);
  const Segment& s = lane.segment;
  const ManifoldDefect defect = lane.patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
  if (defect.kind != ManifoldDefect::Kind::kNone)
    throw GeometryError("the repaired surface is no manifold");
  auto result = std::make_shared<Counted>();
  for (LocalIndex v = 0; v < s.own_vertices; ++v)
    result->unreferenced += !lane.patch.vertex_alive(v);
  result->topology = count_segment(s, lane.patch);
  return result;
}

}  // namespace

MeshCheck check_mesh(const CheckOptions& options, Progress& progress) {
  const unsigned threads =
      options.threads != 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  const MemoryPlan plan = plan_memory(options.memory_bytes, threads, 0, 0);
  MemoryBudget budget(plan.budget_bytes);
  const std::filesystem::path parent =
      options.temp_dir.empty() ? std::filesystem::temp_directory_path() : options.temp_dir;
  check_disk_space(temporary_bytes_needed(options.input), parent);
  const store::TempDir temp(parent);
  const std::uint64_t expected = guess_vertices(options.input);
  progress.plan({expect_ingest(expected), expect_repair(expected), expect_count(expected)});

  const InputMesh input = open_input_mesh(
      options.input, {temp.path(), plan.budget_bytes / 2, options.weld_distance}, budget, progress);
  Ingested ingested =
      ingest(*input.reader, options.input.string(), plan, temp.path(), threads, budget, progress);
  MeshCheck result;
  result.repairs.welded_vertices = input.welded_vertices;
  result.vertices = ingested.vertices;
  result.faces = ingested.faces;
  result.diagonal = ingested.diagonal;
  result.repairs.nonfinite_vertices = ingested.nonfinite_vertices;
  result.nonfinite = ingested.first_nonfinite;
  result.repairs.nonfinite_faces = ingested.nonfinite_faces;
  result.repairs.degenerate_faces = ingested.degenerate_faces;
  const repair::Findings found =
      repair_input(ingested, {}, plan, temp.path(), budget, progress, result.repairs);
  result.defects = found.defects;
  result.places = found.places;
  result.one_sided = found.one_sided;
  if (!found.one_sided.empty()) return result;

  progress.begin("count");
  DomainLevel& level = *ingested.level;
  TopologyCounter counter(temp.path(), ingested.vertices, plan.bucket_bytes / 8, budget);
  const Reservation reservation = reserve_lanes(level, plan, budget);
  std::vector<Lane> lanes(plan.sweep_threads);
  run_ordered(level.segments(), plan.sweep_threads, [&](std::size_t i, unsigned lane) -> Commit {
    progress.check();
    const std::shared_ptr<Counted> part = count(level, i, lanes[lane]);
    return [&, i, part] {
      counter.add(part->topology);
      result.repairs.unreferenced_vertices += part->unreferenced;
      progress.advance(double(i + 1) / double(level.segments()));
    };
  });
  result.topology = counter.finish();
  return result;
}

}  // namespace remaps::pipeline
