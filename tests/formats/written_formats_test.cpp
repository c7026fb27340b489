#include <nlohmann/json.hpp>
#include <regex>

#include "formats/mesh_files.h"
#include "remaps/formats/mesh_writer.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

template <class T>
T load(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.substr(offset, sizeof value).data(), sizeof value);
  return value;
}

class WrittenFormats : public MeshFiles {
 protected:
  /// A tetrahedron with one face once more.
  static MeshContent sample() {
    return {
        {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0.1, 0.2, -4e-8}},
        {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {1, 1, 3}, {0, 1, 2}, {2, 1, 3}},
        true};
  }
  std::string write(std::string_view name, const MeshContent& mesh,
                    const MeshWriterOptions& options = {}) const {
    const auto writer =
        open_mesh_writer(directory() / name, mesh.positions.size(), mesh.triangles.size(), options);
    writer->write_positions(mesh.positions);
    writer->write_triangles(mesh.triangles);
    writer->close();
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory()), {}), 1);
    return bytes_of(directory() / name);
  }
};

TEST_F(WrittenFormats, StlHasTheCornersAndTheNormalOfEachFace) {
  const MeshContent mesh = sample();
  const std::string stl = write("a.stl", mesh);
  ASSERT_EQ(stl.size(), 84 + 50 * mesh.triangles.size());
  EXPECT_NE(stl.substr(0, 5), "solid");
  EXPECT_EQ(load<std::uint32_t>(stl, 80), mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const std::size_t at = 84 + 50 * f;
    std::array<Vec3f, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = load<Vec3f>(stl, at + 12 + 12 * k);
      EXPECT_EQ(corner[k], to_float(mesh.positions[mesh.triangles[f][k]]));
    }
    const Vec3 normal =
        cross(widen(corner[1]) - widen(corner[0]), widen(corner[2]) - widen(corner[0]));
    const Vec3 written = widen(load<Vec3f>(stl, at));
    if (norm(normal) > 0) {
      EXPECT_LT(norm(written - 1 / norm(normal) * normal), 1e-6);
    } else {
      EXPECT_EQ(written, Vec3{});
    }
    EXPECT_EQ(load<std::uint16_t>(stl, at + 48), 0);
  }
  EXPECT_EQ(write("a.stl", {}).size(), 84U);
}

TEST_F(WrittenFormats, GlbSaysItsBoxToTheLastBit) {
  const MeshContent mesh = sample();
  const std::string glb = write("a.glb", mesh);
  EXPECT_EQ(load<std::uint32_t>(glb, 8), glb.size());
  const auto json_bytes = load<std::uint32_t>(glb, 12);
  const Json json = Json::parse(glb.substr(20, json_bytes));
  const auto number =
      json.at("/meshes/0/primitives/0/attributes/POSITION"_json_pointer).get<std::size_t>();
  const Json& positions = json.at("accessors").at(number);
  EXPECT_EQ(positions.at("count"), 4);
  Box3 box;
  for (const Vec3& p : mesh.positions) box.add(widen(to_float(p)));
  EXPECT_EQ(positions.at("min"), (Json{box.low.x, box.low.y, box.low.z}));
  EXPECT_EQ(positions.at("max"), (Json{box.high.x, box.high.y, box.high.z}));
  EXPECT_EQ(json.at("/buffers/0/byteLength"_json_pointer), 12 * 4 + 12 * 8);
  EXPECT_EQ(glb.size(), 20 + json_bytes + 8 + 12 * 4 + 12 * 8);
}

TEST_F(WrittenFormats, GlbHasRoomForTheLongestNumbers) {
  constexpr double kLong = 1.1754943508222875e-38;
  const MeshContent mesh{{{-kLong, -1.2345678e-38, -3.4028234663852886e38},
                          {kLong, 1.2345678e-38, 3.4028234663852886e38},
                          {0, 0, 0}},
                         {{0, 1, 2}},
                         true};
  write("a.glb", mesh);
  const MeshContent read = read_mesh(directory() / "a.glb");
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_EQ(to_float(read.positions[v]), to_float(mesh.positions[v]));
  }
}

TEST_F(WrittenFormats, FormatsWithALimitRefuseWhatIsBeyondIt) {
  const std::uint64_t most_glb_faces = ((std::uint64_t{1} << 32) - 1 - 20 - 1024 - 8 - 36) / 12;
  EXPECT_NO_THROW(check_mesh_size("a.glb", 3, most_glb_faces));
  EXPECT_NO_THROW(open_mesh_writer(directory() / "a.glb", 3, most_glb_faces));
  const std::pair<std::string_view, std::uint64_t> cases[] = {{"a.glb", most_glb_faces + 1},
                                                              {"a.glb", std::uint64_t{1} << 62},
                                                              {"a.stl", std::uint64_t{1} << 32}};
  for (const auto& [name, faces] : cases) {
    try {
      open_mesh_writer(directory() / name, 3, faces);
      ADD_FAILURE() << name;
    } catch (const BudgetError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(name), std::string::npos) << message;
      EXPECT_NE(message.find(".ply"), std::string::npos) << message;
    }
  }
  EXPECT_NO_THROW(check_mesh_size("a.stl", 3, (std::uint64_t{1} << 32) - 1));
  EXPECT_NO_THROW(check_mesh_size("a.vtp", 3, std::uint64_t{1} << 40));
  EXPECT_THROW(check_mesh_size("a.glb", 3, 0), GeometryError);
  EXPECT_THROW(check_mesh_size("a.glb", 0, 0), GeometryError);
  EXPECT_TRUE(std::filesystem::is_empty(directory()));
}

/// Finds the arrays of a .vtp where its XML says they are.
struct VtpArrays {
  explicit VtpArrays(std::string_view file) : bytes(file) {
    begin = bytes.find("<AppendedData encoding=\"raw\">\n_");
    EXPECT_NE(begin, std::string::npos);
    begin = bytes.find('_', begin) + 1;
  }
  /// Checks type and size, and gives the elements.
  template <class T>
  std::vector<T> array(const std::string& type, const std::string& name) const {
    const std::string head(bytes.substr(0, begin));
    const std::regex pattern("<DataArray type=\"" + type + "\" Name=\"" + name +
                             "\"[^>]*offset=\"([0-9]+)\"/>");
    std::smatch match;
    if (!std::regex_search(head, match, pattern)) {
      ADD_FAILURE() << "no " << type << " " << name << " in\n" << head;
      return {};
    }
    const std::size_t at = begin + std::stoul(match[1]);
    std::vector<T> elements(load<std::uint64_t>(bytes, at) / sizeof(T));
    for (std::size_t i = 0; i < elements.size(); ++i) {
      elements[i] = load<T>(bytes, at + 8 + i * sizeof(T));
    }
    end = std::max(end, at + 8 + elements.size() * sizeof(T));
    return elements;
  }

  std::string_view bytes;
  std::size_t begin = 0;
  mutable std::size_t end = 0;
};

TEST_F(WrittenFormats, VtpHasCellsAndWhatIsKnownOfThem) {
  const MeshContent mesh = sample();
  const std::string vtp = write("a.vtp", mesh, {.level = 1});
  EXPECT_NE(vtp.find("NumberOfPoints=\"4\""), std::string::npos);
  EXPECT_NE(vtp.find("NumberOfPolys=\"8\""), std::string::npos);
  const VtpArrays arrays(vtp);
  const auto points = arrays.array<float>("Float32", "Points");
  ASSERT_EQ(points.size(), 12U);
  for (std::size_t v = 0; v < 4; ++v) {
    EXPECT_EQ((Vec3f{points[3 * v], points[3 * v + 1], points[3 * v + 2]}),
              to_float(mesh.positions[v]));
  }
  const auto corners = arrays.array<std::int32_t>("Int32", "connectivity");
  ASSERT_EQ(corners.size(), 24U);
  for (std::size_t c = 0; c < 24; ++c) {
    EXPECT_EQ(static_cast<std::uint64_t>(corners[c]), mesh.triangles[c / 3][c % 3]);
  }
  EXPECT_EQ(arrays.array<std::int32_t>("Int32", "offsets"),
            (std::vector<std::int32_t>{3, 6, 9, 12, 15, 18, 21, 24}));
  EXPECT_EQ(arrays.array<std::uint32_t>("UInt32", "base_face"),
            (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(arrays.array<std::uint8_t>("UInt8", "level"), std::vector<std::uint8_t>(8, 1));
  EXPECT_EQ(arrays.array<std::uint32_t>("UInt32", "patch_id"),
            (std::vector<std::uint32_t>{0, 1, 2, 3, 0, 1, 2, 3}));
  EXPECT_EQ(vtp.substr(arrays.end), "\n</AppendedData>\n</VTKFile>\n");

  const std::string plain = write("a.vtp", mesh);
  EXPECT_EQ(plain.find("CellData"), std::string::npos);
  EXPECT_EQ(write("a.vtp", {}).find("CellData"), std::string::npos);
}

TEST_F(WrittenFormats, VtpWidensIndicesWithTheNumberOfCorners) {
  const std::pair<std::uint64_t, std::string_view> cases[] = {
      {0x7FFFFFFFULL / 3, "Int32\" Name=\"connectivity"},
      {0x7FFFFFFFULL / 3 + 1, "Int64\" Name=\"connectivity"}};
  for (const auto& [faces, type] : cases) {
    const auto writer = open_mesh_writer(directory() / "a.vtp", 100'000, faces);
    writer->write_positions(std::vector<Vec3>(100'000));
    std::string head;
    for (const auto& entry : std::filesystem::directory_iterator(directory())) {
      head = bytes_of(entry.path()).substr(0, 900);
    }
    EXPECT_NE(head.find(type), std::string::npos) << faces << head;
  }
}

TEST_F(WrittenFormats, OffIsPlain) {
  const MeshContent mesh{{{0.1, -0.0, 1e-30}, {1, 2, 3}, {1e20, 0.5, 16777216}}, {{0, 1, 2}}, true};
  EXPECT_EQ(write("a.off", mesh), "OFF\n3 1 0\n0.1 -0 1e-30\n1 2 3\n1e+20 0.5 16777216\n3 0 1 2\n");
}

}  // namespace
}  // namespace remaps
