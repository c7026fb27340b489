#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "archive_text.h"
#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/base/errors.h"
#include "remaps/formats/mesh_reader.h"
#include "remaps/pipeline/codec_files.h"
#include "remaps/pipeline/query.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::filesystem::path path;
  bool quiet = false, json = false;
};

struct MeshInfo {
  std::uint64_t bytes = 0, vertices = 0, faces = 0;
  std::uint64_t nonfinite = 0;  // vertices, which the box leaves out
  Box3 box;
  bool is_float = false;
  std::vector<AttributeSpec> attributes;
  bool is_soup = false;
};

MeshInfo read_mesh(const std::filesystem::path& path, Progress& progress) {
  const auto reader = open_mesh_reader(path);
  const auto advance = [&] { progress.advance(reader->pass_fraction()); };
  MeshInfo info;
  info.bytes = reader->bytes_total();
  progress.begin("vertices");
  reader->read_positions([&](std::span<const Vec3> positions) {
    info.vertices += positions.size();
    for (const Vec3& p : positions) {
      info.box.add(p);  // passes by NaN
      info.nonfinite += std::isnan(p.x);
    }
    advance();
  });
  info.is_float = reader->positions_are_float();
  info.is_soup = reader->vertex_sharing() == VertexSharing::none;
  progress.begin("faces");
  reader->read_triangles([&](std::span<const Triangle> triangles) {
    info.faces += triangles.size();
    advance();
  });
  info.attributes = reader->attributes();
  return info;
}

Json to_json(const AttributeSpec& spec) {
  Json components = Json::array();
  for (const AttributeComponent& c : spec.components) {
    components.push_back({{"name", c.name}, {"type", name_of(c.type)}});
  }
  return {{"name", spec.name},
          {"kind", name_of(spec.kind)},
          {"per", name_of(spec.per)},
          {"components", components}};
}

/// "colour (uint8 red, green, blue), normal (float32 nx, ny, nz), part (of faces, int32)".
std::string to_text(const std::vector<AttributeSpec>& specs) {
  std::string text;
  for (const AttributeSpec& spec : specs) {
    text += fmt::format("{}{} (", text.empty() ? "" : ", ", spec.name);
    if (spec.per != AttributePer::vertex) text += fmt::format("of {}s, ", name_of(spec.per));
    text += name_of(spec.components[0].type);
    if (spec.components.size() > 1) {
      for (std::size_t i = 0; i < spec.components.size(); ++i) {
        text += (i == 0 ? " " : ", ") + spec.components[i].name;
      }
    }
    text += ")";
  }
  return text;
}

std::string to_json(const MeshInfo& info, const std::filesystem::path& path) {
  Json json;
  json["path"] = path.string();
  json["bytes"] = info.bytes;
  json["vertices"] = info.vertices;
  json["nonfinite_vertices"] = info.nonfinite;
  json["faces"] = info.faces;
  json["faces_share_vertices"] = !info.is_soup;
  json["coordinates"] = info.is_float ? "float" : "double";
  if (info.box.empty()) {
    json["bbox"] = nullptr;
  } else {
    const auto& [low, high] = info.box;
    json["bbox"] = {{"low", {low.x, low.y, low.z}}, {"high", {high.x, high.y, high.z}}};
  }
  json["bbox_diagonal"] = info.box.diagonal();
  json["attributes"] = Json::array();
  for (const AttributeSpec& spec : info.attributes) json["attributes"].push_back(to_json(spec));
  // Names need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_table(const MeshInfo& info, const std::filesystem::path& path) {
  std::string text = fmt::format("{}: {}\n", path.string(), bytes_text(info.bytes));
  text += fmt::format("vertices  {}, coordinates are {}\n", with_commas(info.vertices),
                      info.is_float ? "float" : "double");
  if (info.nonfinite > 0) {
    text += fmt::format("          {} not finite, to be dropped with {} faces when remeshed\n",
                        counted(info.nonfinite, "vertex"), info.nonfinite == 1 ? "its" : "their");
  }
  if (info.is_soup) text += "          one a corner: those at one place become one when remeshed\n";
  text += fmt::format("faces     {}, as triangles\n", with_commas(info.faces));
  if (!info.attributes.empty()) text += "carries   " + to_text(info.attributes) + "\n";
  if (!info.box.empty()) {
    const auto& [low, high] = info.box;
    text += fmt::format("box       x {:.7g} … {:.7g}, y {:.7g} … {:.7g}, z {:.7g} … {:.7g}\n",
                        low.x, high.x, low.y, high.y, low.z, high.z);
  }
  return text + fmt::format("diagonal  {:.7g}\n", info.box.diagonal());
}

/// The summary of a manifest that another version may have written: shows what is there.
std::string to_table(const Json& manifest, const std::filesystem::path& path) {
  const Json& input = manifest.at("input");
  const auto number = [&](const char* key) { return input.at(key).get<std::uint64_t>(); };
  std::string text =
      fmt::format("{}: bundle, version {}\n", path.string(), manifest.at("version").dump());
  text += fmt::format("input     {}: {}, {}\n", input.at("name").get<std::string>(),
                      counted(number("vertices"), "vertex"), counted(number("faces"), "face"));
  text += fmt::format("          {}, {}, Euler characteristic {}\n",
                      counted(number("components"), "component"),
                      counted(number("boundary_loops"), "boundary loop"),
                      input.at("euler_characteristic").get<std::int64_t>());
  text += fmt::format("diagonal  {:.7g}\n", input.at("bbox_diagonal").get<double>());
  const MeshInfo base = [&] {
    Progress progress;
    return read_mesh(path / "base.ply", progress);
  }();
  text += fmt::format("base      {}, {} ({} asked for)\n", counted(base.vertices, "vertex"),
                      counted(base.faces, "face"),
                      with_commas(manifest.at("base_vertices_requested").get<std::uint64_t>()));
  if (manifest.contains("attributes")) {
    std::string names;
    for (const Json& spec : manifest.at("attributes").at("list")) {
      names += (names.empty() ? "" : ", ") + spec.at("name").get<std::string>();
    }
    text += fmt::format("carries   {}\n", names);
  }
  if (manifest.contains("feature_angle_deg")) {
    text += fmt::format("features  edges sharper than {:g} degrees\n",
                        manifest.at("feature_angle_deg").get<double>());
  }
  std::string segments;
  for (const Json& level : manifest.at("levels")) {
    if (!segments.empty()) segments += ", ";
    segments += with_commas(level.at("segments").get<std::uint64_t>());
  }
  text += fmt::format("sweeps    {}, of {} segments\n", manifest.at("levels").size(), segments);
  std::uint64_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return text + fmt::format("size      {}\n", bytes_text(bytes));
}

void show_bundle(const Arguments& a) {
  const std::string manifest = pipeline::read_manifest(a.path);
  if (a.json) {
    print(manifest);
    return;
  }
  std::string text;
  try {
    text = to_table(Json::parse(manifest), a.path);
  } catch (const Json::exception& error) {
    throw CorruptionError(fmt::format("{}: malformed manifest: {}", a.path.string(), error.what()));
  }
  print(text);
}

void show_info(const Arguments& a) {
  std::error_code ignored;
  if (std::filesystem::is_directory(a.path, ignored)) {
    show_bundle(a);
    return;
  }
  check_input_file(a.path);
  if (pipeline::is_archive(a.path)) {
    const auto summary = pipeline::summarise_archive(a.path);
    print(a.json ? archive_json(summary, a.path) : archive_table(summary, a.path));
    return;
  }
  MeshInfo info;
  {
    ProgressBar bar(a.quiet);
    info = read_mesh(a.path, bar.progress());
  }
  print(a.json ? to_json(info, a.path) : to_table(info, a.path));
}

}  // namespace

void add_info_command(CLI::App& program, Action& action) {
  CLI::App& verb = add_verb(program, "info", "Say what a mesh file, a bundle or an archive holds",
                            "info scan.remaps --json");
  auto a = std::make_shared<Arguments>();
  add_path(
      verb, "FILE", a->path,
      "A mesh (.ply, .obj, .off, .stl; .gz and .zst of them; .glb, .gltf), a bundle or an archive")
      ->required();
  add_json(verb, a->json);
  add_quiet(verb, a->quiet);
  verb.callback([a, &action] { action = [a] { show_info(*a); }; });
}

}  // namespace remaps::cli
