#include "remaps/formats/gltf_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::uint64_t kTrianglesMode = 4, kLastMode = 6;

bool is_known_extension(std::string_view name) {
  if (name == "KHR_mesh_quantization") return true;
  // These tell how the surface looks, not where it is.
  static constexpr std::string_view kLooks[] = {"KHR_materials_", "KHR_texture_", "KHR_lights_",
                                                "KHR_xmp",        "EXT_texture_", "EXT_lights_",
                                                "MSFT_texture_"};
  return std::any_of(std::begin(kLooks), std::end(kLooks),
                     [&](std::string_view prefix) { return name.starts_with(prefix); });
}

/// @return  whether positions may be integers
bool check_extensions(const GltfValue& root) {
  bool quantized = false;
  if (const auto used = root.find("extensionsUsed")) {
    for (std::size_t i = 0; i < used->size(); ++i) {
      quantized = quantized || used->item(i).text() == "KHR_mesh_quantization";
    }
  }
  if (const auto required = root.find("extensionsRequired")) {
    for (std::size_t i = 0; i < required->size(); ++i) {
      const std::string name = required->item(i).text();
      quantized = quantized || name == "KHR_mesh_quantization";
      if (is_known_extension(name)) continue;
      required->item(i).fail(
          fmt::format("the file cannot be read without {}, which is not supported{}", name,
                      name.find("compression") != std::string::npos
                          ? "; decompress it, for instance with gltf-transform copy"
                          : ""));
    }
  }
  return quantized;
}

template <std::size_t n>
std::array<double, n> read_numbers(const GltfValue& json) {
  if (json.size() != n) json.fail(fmt::format("expected {} numbers, found {}", n, json.size()));
  std::array<double, n> numbers;
  for (std::size_t i = 0; i < n; ++i) numbers[i] = json.item(i).number();
  return numbers;
}

Affine read_matrix(const GltfValue& json) {
  const auto m = read_numbers<16>(json);
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) {
    json.fail("expected 0, 0, 0, 1 as the last row of the matrix");
  }
  return {{Vec3{m[0], m[1], m[2]}, Vec3{m[4], m[5], m[6]}, Vec3{m[8], m[9], m[10]}},
          Vec3{m[12], m[13], m[14]}};
}

Affine read_transform(const GltfValue& node) {
  if (const auto matrix = node.find("matrix")) return read_matrix(*matrix);
  Affine transform;
  if (const auto rotation = node.find("rotation")) {
    const auto [x, y, z, w] = read_numbers<4>(*rotation);
    transform.column = {Vec3{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                        Vec3{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                        Vec3{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
  }
  if (const auto scale = node.find("scale")) {
    const auto s = read_numbers<3>(*scale);
    for (std::size_t i = 0; i < 3; ++i) transform.column[i] = s[i] * transform.column[i];
  }
  if (const auto translation = node.find("translation")) {
    const auto t = read_numbers<3>(*translation);
    transform.shift = {t[0], t[1], t[2]};
  }
  return transform;
}

class SceneBuilder {
 public:
  explicit SceneBuilder(const std::filesystem::path& path)
      : file_(path), root_(file_.root()), reader_(file_) {}

  GltfScene build() {
    const GltfValue version = root_.require("asset").require("version");
    if (!version.text().starts_with("2.")) {
      version.fail(fmt::format("expected glTF 2, found version {}", version.text()));
    }
    quantized_ = check_extensions(root_);
    if (const auto meshes = root_.find("meshes")) primitives_of_.resize(meshes->size());
    add_scene();
    if (scene_.draws.empty()) root_.fail("expected a scene with triangles, found none");
    scene_.buffers = std::move(reader_.buffers());
    scene_.sources = file_.sources();
    return std::move(scene_);
  }

 private:
  void add_scene() {
    const auto nodes = root_.find("nodes");
    seen_.assign(nodes ? nodes->size() : 0, false);
    const auto scenes = root_.find("scenes");
    if (const auto chosen = root_.find("scene")) {
      add_nodes(chosen->element(root_, "scenes"));
    } else if (scenes && scenes->size() > 0) {
      add_nodes(scenes->item(0));
    } else if (!seen_.empty()) {
      add_roots(*nodes);
    } else {
      for (std::size_t i = 0; i < primitives_of_.size(); ++i) {
        add_mesh(root_.require("meshes").item(i), i, {});
      }
    }
  }

  void add_nodes(const GltfValue& scene) {
    const auto nodes = scene.find("nodes");
    for (std::size_t i = 0; nodes && i < nodes->size(); ++i) add_tree(nodes->item(i));
  }

  /// Without a scene: all nodes that are nobody's children.
  void add_roots(const GltfValue& nodes) {
    std::vector<bool> is_child(seen_.size());
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const auto children = nodes.item(i).find("children");
      for (std::size_t k = 0; children && k < children->size(); ++k) {
        const GltfValue child = children->item(k);
        child.element(root_, "nodes");
        is_child[static_cast<std::size_t>(child.whole())] = true;
      }
    }
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      if (is_child[i]) continue;
      seen_[i] = true;
      add_below(nodes.item(i), {});
    }
  }

  void add_tree(const GltfValue& reference) { add_below(visit(reference), {}); }

  /// The node that a number names; each may be met once.
  GltfValue visit(const GltfValue& reference) {
    const GltfValue node = reference.element(root_, "nodes");
    const auto number = static_cast<std::size_t>(reference.whole());
    if (seen_[number]) {
      reference.fail(
          fmt::format("expected nodes that form trees, but nodes[{}] is reached twice: "
                      "it has two parents, or is below itself",
                      number));
    }
    seen_[number] = true;
    return node;
  }

  void add_below(const GltfValue& root, const Affine& parent) {
    std::vector<std::pair<GltfValue, Affine>> waiting{{root, parent}};
    while (!waiting.empty()) {
      const auto [node, above] = std::move(waiting.back());
      waiting.pop_back();
      const Affine transform = above * read_transform(node);
      if (const auto extensions = node.find("extensions")) {
        if (const auto instances = extensions->find("EXT_mesh_gpu_instancing")) {
          instances->fail("instances of this extension are not supported");
        }
      }
      if (const auto mesh = node.find("mesh")) {
        add_mesh(mesh->element(root_, "meshes"), static_cast<std::size_t>(mesh->whole()),
                 transform);
      }
      if (const auto children = node.find("children")) {
        // The first child is to be next.
        for (std::size_t i = children->size(); i-- > 0;) {
          waiting.emplace_back(visit(children->item(i)), transform);
        }
      }
    }
  }

  void add_mesh(const GltfValue& mesh, std::size_t number, const Affine& transform) {
    std::optional<std::vector<std::uint32_t>>& primitives = primitives_of_[number];
    if (!primitives) primitives = read_primitives(mesh);
    if (primitives->empty()) return;
    const auto transform_number = narrow<std::uint32_t>(scene_.transforms.size());
    scene_.transforms.push_back(transform);
    // Of the vertices that this instance has already.
    std::map<std::pair<std::size_t, GltfAttributes>, VertexId> first_of;
    for (const std::uint32_t p : *primitives) {
      if (scene_.draws.size() == kMostGltfDraws) {
        mesh.fail(fmt::format("expected at most {} primitives in the scene, instances counted",
                              kMostGltfDraws));
      }
      const GltfPrimitive& primitive = scene_.primitives[p];
      const auto [first, fresh] =
          first_of.try_emplace({primitive.positions, primitive.attributes}, scene_.vertices);
      const GltfAccessor& positions = scene_.accessors[primitive.positions];
      if (fresh) {
        scene_.parts.push_back(
            {narrow<std::uint32_t>(primitive.positions), transform_number, p, scene_.vertices});
        scene_.vertices += positions.count;
      }
      scene_.draws.push_back({p, transform_number, first->second});
      scene_.corners +=
          primitive.indices ? scene_.accessors[*primitive.indices].count : positions.count;
    }
  }

  /// Those of triangles; points and lines are passed over.
  std::vector<std::uint32_t> read_primitives(const GltfValue& mesh) {
    std::vector<std::uint32_t> numbers;
    const GltfValue all = mesh.require("primitives");
    for (std::size_t i = 0; i < all.size(); ++i) {
      const GltfValue json = all.item(i);
      const std::uint64_t mode = json.count("mode", kTrianglesMode);
      if (mode > kLastMode) {
        json.require("mode").fail(fmt::format("expected 0 to {}, found {}", kLastMode, mode));
      }
      if (mode < kTrianglesMode) continue;
      numbers.push_back(narrow<std::uint32_t>(scene_.primitives.size()));
      scene_.primitives.push_back(read_primitive(json, static_cast<GltfMode>(mode)));
    }
    return numbers;
  }

  GltfPrimitive read_primitive(const GltfValue& json, GltfMode mode) {
    GltfPrimitive primitive;
    primitive.place = json.place();
    primitive.mode = mode;
    const GltfValue reference = json.require("attributes").require("POSITION");
    const GltfValue accessor = reference.element(root_, "accessors");
    if (const auto extensions = json.find("extensions")) {
      const auto draco = extensions->find("KHR_draco_mesh_compression");
      if (draco && !accessor.find("bufferView")) {
        draco->fail(
            "Draco compression is not supported; decompress the file, for instance with "
            "gltf-transform copy");
      }
    }
    primitive.positions = accessor_number(accessor, "VEC3");
    check_positions(accessor, scene_.accessors[primitive.positions]);
    primitive.attributes =
        read_attributes(json.require("attributes"), scene_.accessors[primitive.positions].count);
    if (const auto material = json.find("material")) primitive.material = material->whole();
    if (const auto indices = json.find("indices")) {
      const GltfValue index_accessor = indices->element(root_, "accessors");
      primitive.indices = accessor_number(index_accessor, "SCALAR");
      const GltfComponent type = scene_.accessors[*primitive.indices].component;
      if (type != GltfComponent::u8 && type != GltfComponent::u16 && type != GltfComponent::u32) {
        index_accessor.require("componentType")
            .fail("expected an unsigned type (5121, 5123 or 5125) for indices");
      }
    }
    return primitive;
  }

  GltfAttributes read_attributes(const GltfValue& json, std::uint64_t vertices) {
    GltfAttributes found;
    const auto read = [&](const std::string& name, std::initializer_list<std::string_view> types) {
      const auto reference = json.find(name);
      return reference ? attribute_number(*reference, types, vertices) : GltfAttributes::kNone;
    };
    found.normal = read("NORMAL", {"VEC3"});
    found.colour = read("COLOR_0", {"VEC3", "VEC4"});
    for (std::size_t set = 0; set < GltfAttributes::kTextures; ++set) {
      found.texture[set] = read(fmt::format("TEXCOORD_{}", set), {"VEC2"});
    }
    return found;
  }

  /// The accessor of an attribute; kNone for one of zeros, which says as much as none.
  std::uint32_t attribute_number(const GltfValue& reference,
                                 std::initializer_list<std::string_view> types,
                                 std::uint64_t vertices) {
    const GltfValue json = reference.element(root_, "accessors");
    if (!json.find("bufferView") && !json.find("sparse")) return GltfAttributes::kNone;
    const std::string type = json.require("type").text();
    if (std::find(types.begin(), types.end(), type) == types.end()) {
      json.require("type").fail(fmt::format("expected {} for {}, found {}",
                                            fmt::join(types, " or "), reference.place(), type));
    }
    const std::size_t number = accessor_number(json, type);
    const GltfAccessor& accessor = scene_.accessors[number];
    if (accessor.component == GltfComponent::u32) {
      json.require("componentType")
          .fail(fmt::format("expected floats or integers of at most 16 bits for {}",
                            reference.place()));
    }
    if (accessor.count != vertices) {
      json.require("count").fail(
          fmt::format("expected {}, as many as there are positions for {}, "
                      "found {}",
                      vertices, reference.place(), accessor.count));
    }
    return narrow<std::uint32_t>(number);
  }

  void check_positions(const GltfValue& json, const GltfAccessor& accessor) const {
    if (accessor.component == GltfComponent::f32) return;
    if (accessor.component != GltfComponent::u32 && quantized_) return;
    json.require("componentType")
        .fail(quantized_ ? "expected floats or integers of at most 16 bits for positions"
                         : "expected floats (5126) for positions: integers need the extension "
                           "KHR_mesh_quantization");
  }

  /// Reads an accessor when it is first asked for.
  std::size_t accessor_number(const GltfValue& json, std::string_view type) {
    const auto [at, fresh] =
        number_of_.try_emplace({json.place(), std::string(type)}, scene_.accessors.size());
    if (fresh) scene_.accessors.push_back(reader_.read(json, type));
    return at->second;
  }

  GltfFile file_;
  GltfValue root_;
  GltfAccessorReader reader_;
  GltfScene scene_;
  bool quantized_ = false;
  std::vector<bool> seen_;                                                // (nodes)
  std::vector<std::optional<std::vector<std::uint32_t>>> primitives_of_;  // (meshes)
  std::map<std::pair<std::string, std::string>, std::size_t> number_of_;  // accessors
};

}  // namespace

GltfScene read_gltf_scene(const std::filesystem::path& path) {
  return SceneBuilder(path).build();
}

}  // namespace remaps
