#include "remaps/pipeline/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "remaps/formats/file_extension.h"
#include "remaps/formats/mesh_reader.h"

namespace remaps::pipeline {
namespace {

// Bytes of a vertex and its two faces.
constexpr std::uint64_t kBinaryBytes = 38, kTextBytes = 85, kStlBytes = 100;

// Nanoseconds of one thread, from the seconds in the reports of a generated scan of 14 M vertices
// and of Earth at 0.6 and 9 M (docs/design/profile.md). What counts are the proportions.
constexpr double kIngest = 130;          // a vertex
constexpr double kAttributes = 100;      // a vertex
constexpr double kRepair = 2000;         // a vertex
constexpr double kCount = 400;           // a vertex
constexpr double kSweep = 1300;          // a vertex of the level
constexpr double kLastSweep = 12'400;    // a vertex of the level
constexpr double kMapStep = 24;          // a step of an input vertex through the logs
constexpr double kLogs = 125;            // an input vertex: records and tiles are read once
constexpr double kResample = 1000;       // a vertex of the output
constexpr double kFit = 40'000;          // a vertex of the output
constexpr double kMeasureInput = 175;    // an input vertex
constexpr double kMeasureOutput = 1500;  // a vertex of the output
constexpr double kSample = 500;          // a sample

/// Steps through the logs that a vertex takes from a mesh of `vertices` to one of `left`: each
/// removal touches about six faces of twice as many as there are vertices.
double steps(std::uint64_t vertices, std::uint64_t left) {
  return 3 * std::log(std::max(2.0, double(vertices) / double(std::max<std::uint64_t>(left, 4))));
}

/// Vertices at the borders of segments of so many faces, as a fraction of all: they stay.
double locked_fraction(std::uint64_t segment_faces) {
  return std::min(0.9, 7 / std::sqrt(double(segment_faces)));
}

}  // namespace

std::uint64_t guess_vertices(const std::filesystem::path& path) {
  const std::string extension = content_extension(path);
  const bool is_binary = extension == ".ply" || extension == ".glb";
  return guess_content_bytes(path) / (is_binary             ? kBinaryBytes
                                      : extension == ".stl" ? kStlBytes
                                                            : kTextBytes);
}

PlannedPhase expect_ingest(std::uint64_t vertices) {
  return {"ingest", kIngest * double(vertices)};
}

PlannedPhase expect_attributes(std::uint64_t vertices) {
  return {"attributes", kAttributes * double(vertices)};
}

PlannedPhase expect_repair(std::uint64_t vertices) {
  return {"repair", kRepair * double(vertices)};
}

PlannedPhase expect_count(std::uint64_t vertices) {
  return {"count", kCount * double(vertices)};
}

std::vector<PlannedPhase> expect_sweeps(std::uint64_t vertices, std::uint64_t input_vertices,
                                        unsigned levels_before, const MemoryPlan& plan,
                                        FunctionRef<double(std::uint64_t)> keep) {
  std::vector<PlannedPhase> phases;
  unsigned levels = levels_before;
  const double locked = locked_fraction(plan.segment_faces);
  while (2 * vertices > plan.domain_buffer && levels < levels_before + 30) {
    phases.push_back({fmt::format("sweep {}", ++levels), kSweep * double(vertices)});
    const double kept = locked + (1 - locked) * keep(vertices);
    vertices = static_cast<std::uint64_t>(kept * double(vertices));
  }
  phases.push_back({"last sweep", kLastSweep * double(vertices)});
  phases.push_back({"map", kMapStep * steps(input_vertices, 200) * double(input_vertices)});
  return phases;
}

std::vector<PlannedPhase> expect_output(const ExpectedOutput& o) {
  std::vector<PlannedPhase> phases;
  phases.push_back({"resample", kLogs * double(o.input_vertices) + kResample * double(o.vertices)});
  if (o.fit) phases.push_back({"fit", kFit * double(o.vertices)});
  if (o.measure) {
    phases.push_back({"measure", kMeasureInput * double(o.input_vertices) +
                                     kMeasureOutput * double(o.vertices) +
                                     2 * kSample * double(o.samples)});
  }
  return phases;
}

}  // namespace remaps::pipeline
