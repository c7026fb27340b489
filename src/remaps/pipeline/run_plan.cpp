#include "remaps/pipeline/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "remaps/formats/file_extension.h"

namespace remaps::pipeline {
namespace {

// Bytes of a vertex and its two faces.
constexpr std::uint64_t kBinaryBytes = 38, kTextBytes = 85;

// Nanoseconds of one thread, from the seconds in the reports of generated scans of 1.4 and 14 M
// vertices. What counts are the proportions.
constexpr double kIngest = 285;          // a vertex
constexpr double kSweep = 3400;          // a vertex of the level
constexpr double kLastSweep = 2600;      // a vertex of the level
constexpr double kMapLevel = 370;        // an input vertex and level
constexpr double kLogs = 150;            // an input vertex: records and tiles are read once
constexpr double kResample = 950;        // a vertex of the output
constexpr double kFit = 40'000;          // a vertex of the output
constexpr double kMeasureInput = 350;    // an input vertex
constexpr double kMeasureOutput = 5000;  // a vertex of the output
constexpr double kSample = 4000;         // a sample

/// Vertices at the borders of segments of so many faces, as a fraction of all: they stay.
double locked_fraction(std::uint64_t segment_faces) {
  return std::min(0.9, 7 / std::sqrt(double(segment_faces)));
}

}  // namespace

std::uint64_t guess_vertices(const std::filesystem::path& path) {
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(path, error);
  if (error) return 0;
  const std::string extension = lower_extension(path);
  const bool is_binary = extension == ".ply" || extension == ".glb";
  return bytes / (is_binary ? kBinaryBytes : kTextBytes);
}

PlannedPhase expect_ingest(std::uint64_t vertices) {
  return {"ingest", kIngest * double(vertices)};
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
  phases.push_back({"map", kMapLevel * double(levels + 1) * double(input_vertices)});
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
