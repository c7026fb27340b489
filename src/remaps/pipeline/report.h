#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "remaps/measure/surface_error.h"

namespace remaps::pipeline {

/// What of the input could not be taken as it is.
struct Repairs {
  std::uint64_t welded_vertices = 0;        ///< joined to others
  std::uint64_t unreferenced_vertices = 0;  ///< have no face, or none that is left
  std::uint64_t nonfinite_vertices = 0, nonfinite_faces = 0;  ///< dropped, with their faces
  std::uint64_t degenerate_faces = 0;                         ///< dropped: a vertex twice
  std::uint64_t duplicate_faces = 0;                          ///< dropped
  std::uint64_t flipped_faces = 0;         ///< turned to agree with their neighbours
  std::uint64_t nonmanifold_edges = 0;     ///< of more than two faces: cut
  std::uint64_t nonmanifold_vertices = 0;  ///< of several fans: split
  std::uint64_t split_vertices = 0;        ///< copies made where edges were cut or vertices split
  std::uint64_t dropped_components = 0, dropped_component_faces = 0;  ///< too small
  std::uint64_t filled_holes = 0, filled_faces = 0;
};

enum class ErrorKind { kL2, kMax };

/// An error that the output must not exceed.
struct ErrorGoal {
  double most = 0;  ///< fraction of the diagonal, two-sided; 0: no goal
  ErrorKind kind = ErrorKind::kL2;
  std::uint64_t max_faces = 0;  ///< of the output; 0: 16 times the input's

  bool any() const { return most > 0; }
};

/// An output that was tried for that.
struct ErrorAttempt {
  std::uint64_t base_vertices = 0;
  unsigned level = 0;
  std::uint64_t faces = 0;
  double l2 = 0, max = 0;  ///< fractions of the diagonal, the larger of both ways
};

/// What a run did, as --report writes it. The keys of the JSON are part of the contract; see
/// docs/formats/report.md.
struct Report {
  struct Sweep {
    std::uint64_t faces_in = 0, faces_out = 0, segments = 0;
  };
  struct MemorySample {
    double seconds = 0;
    std::uint64_t rss_bytes = 0;
  };
  struct Attribute {
    std::string name, kind, per;
    bool written = false;  ///< false: the format of the output has no place for it
  };
  struct Output {
    std::string path;
    unsigned level = 0;
    std::uint64_t vertices = 0, faces = 0;
  };
  /// How evenly the map spreads the surface over the base.
  struct Quality {
    double area_ratio = 0;  ///< largest to median surface area of a base face
    double l2_stretch = 0;  ///< area-weighted, 1 = isometric up to scale [Sander 2001]
  };

  /// Sharp edges that were kept.
  struct Features {
    double angle_deg = 0;             ///< 0: none by angle
    std::vector<std::string> labels;  ///< that faces on both sides differ in
    std::uint64_t edges = 0;          ///< of the input, sharper than that or between labels
    std::uint64_t dropped_edges = 0;  ///< in short chains with a loose end
    std::uint64_t corners = 0;        ///< vertices of the base that features keep there
    std::uint64_t base_edges = 0;     ///< of the base that lie on features
    /// What the base could come down to, where that is more than asked for, else 0. It is larger.
    std::uint64_t least_base_vertices = 0;
  };

  std::string input_path;
  std::uint64_t input_vertices = 0, input_faces = 0;
  double bbox_diagonal = 0;
  std::uint64_t components = 0, boundary_loops = 0;
  std::int64_t euler_characteristic = 0;
  Repairs repairs;

  std::optional<Features> features;  ///< with feature_angle_deg or feature_labels
  std::uint64_t base_vertices_requested = 0;
  std::uint64_t base_vertices = 0, base_faces = 0;
  unsigned level = 0;
  std::string output_path;  ///< of the finest mesh, as all of `output` is
  std::uint64_t output_vertices = 0, output_faces = 0;
  std::vector<Output> outputs;  ///< one a level, the coarsest first; without --levels the only one

  double seconds_ingest = 0, seconds_sweeps = 0, seconds_map = 0, seconds_resample = 0,
         seconds_measure = 0, seconds_total = 0;
  double cpu_seconds = 0;
  std::uint64_t peak_rss_bytes = 0, memory_budget_bytes = 0;
  std::uint64_t bytes_read = 0, bytes_written = 0;
  std::uint64_t peak_temp_bytes = 0, planned_temp_bytes = 0;
  unsigned threads = 1;
  std::uint64_t domain_buffer = 0, map_buffer = 0;
  std::vector<Sweep> sweeps;
  std::vector<Attribute> attributes;  ///< that the bundle or the output has
  std::optional<SurfaceError> error;
  ErrorGoal goal;
  std::vector<ErrorAttempt> attempts;  ///< for the goal; the last is the output
  std::optional<Quality> quality;
  std::vector<MemorySample> memory_trace;
};

std::string to_json(const Report& report);

}  // namespace remaps::pipeline
