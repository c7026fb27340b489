#include "report_table.h"

#include <fmt/format.h>

#include <filesystem>

#include "number_text.h"

namespace remaps::cli {
namespace {

using pipeline::Report;

std::string name_of(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

std::string topology_text(const Report& r) {
  std::string text = counted(r.components, "component");
  text += r.boundary_loops == 0 ? ", closed"
                                : fmt::format(", {}", counted(r.boundary_loops, "boundary loop"));
  if (r.components == 1) {
    const std::int64_t handles =
        (2 - r.euler_characteristic - static_cast<std::int64_t>(r.boundary_loops)) / 2;
    text += fmt::format(", genus {}", handles);
  }
  if (r.repairs.unreferenced_vertices != 0) {
    text += fmt::format(", {} without a face", counted(r.repairs.unreferenced_vertices, "vertex"));
  }
  if (r.repairs.welded_vertices != 0) {
    text += fmt::format(", {} welded", counted(r.repairs.welded_vertices, "vertex"));
  }
  return text;
}

/// What repair did, an item each; empty when there was nothing to do.
std::string repair_text(const pipeline::Repairs& r) {
  std::string text;
  const auto add = [&](std::uint64_t count, const char* noun, const char* what) {
    if (count == 0) return;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counted(count, noun), what);
  };
  add(r.nonfinite_vertices, "vertex", "not finite dropped");
  add(r.nonfinite_faces, "face", "with them");
  add(r.degenerate_faces, "degenerate face", "dropped");
  add(r.duplicate_faces, "duplicate face", "dropped");
  add(r.dropped_components, "small component", "dropped");
  add(r.flipped_faces, "face", "turned");
  add(r.nonmanifold_edges, "edge", "of more than two faces cut");
  add(r.nonmanifold_vertices, "vertex", "with several fans split");
  add(r.filled_holes, "hole", "filled");
  return text;
}

std::string features_text(const Report::Features& f) {
  std::string text = counted(f.edges, "edge");
  if (f.angle_deg > 0) text += fmt::format(" sharper than {:g} degrees", f.angle_deg);
  if (!f.labels.empty()) {
    text += fmt::format("{} between faces of different {}", f.angle_deg > 0 ? " or" : "",
                        fmt::join(f.labels, ", "));
  }
  if (f.dropped_edges != 0)
    text += fmt::format(", {} too short to keep", with_commas(f.dropped_edges));
  return text + fmt::format("; on the base {}, {}", counted(f.base_edges, "edge"),
                            counted(f.corners, "corner"));
}

/// Why the base has more vertices than asked for.
std::string larger_base_text(const Report& r) {
  const bool featured = r.features && r.features->least_base_vertices != 0;
  std::string text =
      fmt::format("asked for {} base vertices; {} allow no fewer than {}",
                  with_commas(r.base_vertices_requested),
                  featured ? "features, topology and shape" : "topology and shape",
                  with_commas(featured ? r.features->least_base_vertices : r.base_vertices));
  if (featured) text += fmt::format("\n{:<9} half as many more are kept; fewer spoil the map", "");
  return text;
}

/// "colour, normal; not label, for which the format has no place".
std::string attributes_text(const Report& r) {
  std::string written, left_out;
  for (const Report::Attribute& a : r.attributes) {
    std::string& list = a.written ? written : left_out;
    list += (list.empty() ? "" : ", ") + a.name;
    if (a.per != "vertex") list += fmt::format(" (of {}s)", a.per);
  }
  if (left_out.empty()) return written;
  if (!written.empty()) written += "; ";
  return written + fmt::format("not {}, for which the format has no place", left_out);
}

std::string error_lines(const SurfaceError& error) {
  constexpr const char* kRow = "{:<9} {:<16} L2 {:>9}   max {:>9}\n";
  std::string text = fmt::format(kRow, "error", "input to output", error_text(error.l2_forward),
                                 error_text(error.max_forward));
  text += fmt::format(kRow, "", "output to input", error_text(error.l2_backward),
                      error_text(error.max_backward));
  return text + fmt::format("{:<9} of the diagonal; PSNR {}\n", "", psnr_text(error.l2()));
}

std::string time_lines(const Report& r) {
  const std::pair<const char*, double> phases[] = {{"ingest", r.seconds_ingest},
                                                   {"sweeps", r.seconds_sweeps},
                                                   {"map", r.seconds_map},
                                                   {"resample", r.seconds_resample},
                                                   {"measure", r.seconds_measure}};
  std::string list;
  for (const auto& [name, seconds] : phases) {
    if (seconds <= 0) continue;
    if (!list.empty()) list += ", ";
    list += fmt::format("{} {}", name, seconds_text(seconds));
  }
  return fmt::format("{:<9} {}; CPU {} on {}\n{:<9} {}\n", "time", seconds_text(r.seconds_total),
                     seconds_text(r.cpu_seconds), counted(r.threads, "thread"), "", list);
}

}  // namespace

std::string report_table(const Report& r) {
  const auto line = [](const char* head, const std::string& text) {
    return fmt::format("{:<9} {}\n", head, text);
  };
  const auto mesh = [](std::uint64_t vertices, std::uint64_t faces) {
    return counted(vertices, "vertex") + ", " + counted(faces, "face");
  };
  std::string text = line(
      "input", fmt::format("{}: {}", name_of(r.input_path), mesh(r.input_vertices, r.input_faces)));
  text += line("", topology_text(r));
  if (const std::string repairs = repair_text(r.repairs); !repairs.empty())
    text += line("repaired", repairs);
  if (r.features) text += line("features", features_text(*r.features));
  text += line("base", mesh(r.base_vertices, r.base_faces));
  if (r.base_vertices_requested != 0 && r.base_vertices > r.base_vertices_requested) {
    text += line("", larger_base_text(r));
  }
  if (!r.output_path.empty()) {
    text += line("output", fmt::format("{}: {}, level {}", name_of(r.output_path),
                                       mesh(r.output_vertices, r.output_faces), r.level));
    for (const Report::Output& output : r.outputs) {
      if (output.level == r.level) continue;
      text += line("", fmt::format("{}: {}, level {}", name_of(output.path),
                                   mesh(output.vertices, output.faces), output.level));
    }
  }
  if (r.goal.any()) {
    text += line("", fmt::format("the lowest level of {} tried with an error of {} at most",
                                 r.attempts.size(), error_text(r.goal.most)));
  }
  if (!r.attributes.empty()) text += line("carried", attributes_text(r));
  if (r.error) text += error_lines(*r.error);
  if (r.quality) {
    text +=
        line("quality", fmt::format("L2 stretch {:.2f}; largest base face {:.1f} times the median",
                                    r.quality->l2_stretch, r.quality->area_ratio));
  }
  text += time_lines(r);
  text +=
      line("memory", fmt::format("peak {} of {}, with program and libraries",
                                 bytes_text(r.peak_rss_bytes), bytes_text(r.memory_budget_bytes)));
  text += line("disk", fmt::format("read {}, wrote {}", bytes_text(r.bytes_read),
                                   bytes_text(r.bytes_written)));
  return text;
}

}  // namespace remaps::cli
