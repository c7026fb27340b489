#include "archive_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "number_text.h"

namespace remaps::cli {
namespace {

constexpr std::array<std::string_view, 3> kWavelets = {"butterfly", "butterfly-lifted", "loop"};

std::string_view name_of(codec::SignalKind kind) {
  return kind == codec::SignalKind::kColour ? "colour" : "normal";
}

}  // namespace

std::vector<std::string> wavelet_names() {
  return {kWavelets.begin(), kWavelets.end()};
}

std::string name_of(codec::Wavelet wavelet) {
  return std::string(kWavelets[static_cast<std::size_t>(wavelet)]);
}

codec::Wavelet wavelet_named(const std::string& name) {
  const auto at = std::find(kWavelets.begin(), kWavelets.end(), name);
  return static_cast<codec::Wavelet>(at - kWavelets.begin());
}

std::string archive_table(const pipeline::ArchiveSummary& s, const std::filesystem::path& path) {
  const codec::ArchiveHeader& h = s.header;
  std::string text = fmt::format(
      "{}: archive, {} bytes{}\n", path.string(), with_commas(s.bytes),
      s.complete ? "" : fmt::format(" of {}: the beginning of one", with_commas(s.complete_bytes)));
  text += fmt::format("base      {}, {}: {} bytes\n", counted(h.base_vertices, "vertex"),
                      counted(h.base_faces, "face"), with_commas(h.base_bytes));
  text += fmt::format("level     {}: {}\n", h.levels, counted(s.faces, "face"));
  text += fmt::format("details   {} wavelets, {} bitplanes: {} bytes\n", name_of(h.wavelet),
                      h.quantization.planes, with_commas(h.geometry_bytes));
  for (const codec::SignalHeader& signal : s.signals) {
    text += fmt::format("{:<10}{} bitplanes: {} bytes\n", name_of(signal.kind),
                        signal.quantization.planes, with_commas(signal.bytes));
  }
  text += fmt::format("prefixes  from {} bytes on can be decoded\n", with_commas(s.least_bytes));
  if (s.points.empty()) return text;
  text += fmt::format("\n{:>12} {:>10} {:>12}\n", "bytes", "PSNR", "L2");
  for (const codec::RatePoint& p : s.points) {
    const double psnr = static_cast<double>(p.psnr_db);
    text += fmt::format("{:>12} {:>7.2f} dB {:>12}\n", with_commas(p.bytes), psnr,
                        error_text(std::pow(10, -psnr / 20)));
  }
  return text + "L2 is a fraction of the diagonal\n";
}

std::string archive_json(const pipeline::ArchiveSummary& s, const std::filesystem::path& path) {
  const codec::ArchiveHeader& h = s.header;
  nlohmann::ordered_json json;
  json["path"] = path.string();
  json["bytes"] = s.bytes;
  json["complete_bytes"] = s.complete_bytes;
  json["least_bytes"] = s.least_bytes;
  json["wavelet"] = name_of(h.wavelet);
  json["bitplanes"] = h.quantization.planes;
  json["level"] = h.levels;
  json["faces"] = s.faces;
  json["base"] = {{"vertices", h.base_vertices}, {"faces", h.base_faces}, {"bytes", h.base_bytes}};
  json["details"] = {{"bytes", h.geometry_bytes}};
  json["attributes"] = nlohmann::ordered_json::array();
  for (const codec::SignalHeader& signal : s.signals) {
    json["attributes"].push_back({{"name", name_of(signal.kind)},
                                  {"bitplanes", signal.quantization.planes},
                                  {"bytes", signal.bytes}});
  }
  json["rate_distortion"] = nlohmann::ordered_json::array();
  for (const codec::RatePoint& p : s.points) {
    json["rate_distortion"].push_back({{"bytes", p.bytes}, {"psnr", p.psnr_db}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string decoded_text(const pipeline::DecodeSummary& s, const std::filesystem::path& output) {
  return fmt::format("{}: {}, {}, level {}, of {} bytes\n", output.string(),
                     counted(s.vertices, "vertex"), counted(s.faces, "face"), s.level,
                     with_commas(s.bytes));
}

}  // namespace remaps::cli
