#include "remaps/pipeline/report.h"

#include <nlohmann/json.hpp>

#include "remaps/pipeline/repair_counts.h"

namespace remaps::pipeline {

std::string to_json(const Report& r) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["input"] = {{"path", r.input_path},
                   {"vertices", r.input_vertices},
                   {"faces", r.input_faces},
                   {"bbox_diagonal", r.bbox_diagonal},
                   {"components", r.components},
                   {"boundary_loops", r.boundary_loops},
                   {"euler_characteristic", r.euler_characteristic}};
  for (const auto& [name, count] : repair_counts(r.repairs)) json["repairs"][name] = count;
  if (r.features) {
    json["features"] = {{"angle_deg", r.features->angle_deg},
                        {"labels", r.features->labels},
                        {"edges", r.features->edges},
                        {"dropped_edges", r.features->dropped_edges},
                        {"corners", r.features->corners},
                        {"base_edges", r.features->base_edges},
                        {"least_base_vertices", r.features->least_base_vertices}};
  }
  json["base"] = {{"vertices", r.base_vertices},
                  {"faces", r.base_faces},
                  {"vertices_requested", r.base_vertices_requested}};
  json["level"] = r.level;
  json["output"] = {
      {"path", r.output_path}, {"vertices", r.output_vertices}, {"faces", r.output_faces}};
  json["attributes"] = Json::array();
  for (const Report::Attribute& a : r.attributes) {
    json["attributes"].push_back(
        {{"name", a.name}, {"kind", a.kind}, {"per", a.per}, {"written", a.written}});
  }
  json["outputs"] = Json::array();
  for (const Report::Output& output : r.outputs) {
    json["outputs"].push_back({{"path", output.path},
                               {"level", output.level},
                               {"vertices", output.vertices},
                               {"faces", output.faces}});
  }
  json["seconds"] = {{"ingest", r.seconds_ingest},   {"sweeps", r.seconds_sweeps},
                     {"map", r.seconds_map},         {"resample", r.seconds_resample},
                     {"measure", r.seconds_measure}, {"total", r.seconds_total}};
  json["cpu_seconds"] = r.cpu_seconds;
  json["threads"] = r.threads;
  json["peak_rss_bytes"] = r.peak_rss_bytes;
  json["memory_budget_bytes"] = r.memory_budget_bytes;
  json["domain_buffer"] = r.domain_buffer;
  json["map_buffer"] = r.map_buffer;
  json["io"] = {{"bytes_read", r.bytes_read},
                {"bytes_written", r.bytes_written},
                {"peak_temp_bytes", r.peak_temp_bytes},
                {"planned_temp_bytes", r.planned_temp_bytes}};
  json["sweeps"] = Json::array();
  for (const Report::Sweep& sweep : r.sweeps) {
    json["sweeps"].push_back({{"faces_in", sweep.faces_in},
                              {"faces_out", sweep.faces_out},
                              {"segments", sweep.segments}});
  }
  if (r.error) {
    json["error"] = {{"l2_forward", r.error->l2_forward},
                     {"l2_backward", r.error->l2_backward},
                     {"l2", r.error->l2()},
                     {"mean_forward", r.error->mean_forward},
                     {"mean_backward", r.error->mean_backward},
                     {"max_forward", r.error->max_forward},
                     {"max_backward", r.error->max_backward}};
  }
  if (r.goal.any()) {
    Json attempts = Json::array();
    for (const ErrorAttempt& a : r.attempts) {
      attempts.push_back({{"base_vertices", a.base_vertices},
                          {"level", a.level},
                          {"faces", a.faces},
                          {"l2", a.l2},
                          {"max", a.max}});
    }
    json["goal"] = {{"max_error", r.goal.most},
                    {"kind", r.goal.kind == ErrorKind::kL2 ? "l2" : "max"},
                    {"max_faces", r.goal.max_faces},
                    {"attempts", attempts}};
  }
  if (r.quality) {
    json["quality"] = {{"area_ratio", r.quality->area_ratio},
                       {"l2_stretch", r.quality->l2_stretch}};
  }
  json["memory_trace"] = Json::array();
  for (const Report::MemorySample& sample : r.memory_trace) {
    json["memory_trace"].push_back({{"seconds", sample.seconds}, {"rss_bytes", sample.rss_bytes}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace remaps::pipeline
