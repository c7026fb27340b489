#include "remaps/formats/mesh_writer.h"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <limits>

#include "formats/mesh_files.h"

namespace remaps {
namespace {

class MeshWriter : public MeshFiles {
 protected:
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(directory()), {}));
  }
};

/// A mesh of n vertices and n - 2 triangles with floats of all magnitudes.
MeshContent sample_mesh(std::size_t n) {
  MeshContent mesh;
  for (std::size_t i = 0; i < n; ++i) {
    const auto t = static_cast<float>(i);
    mesh.positions.push_back(widen({t / 3, -1e-30F * t, 1e30F / (1 + t)}));
  }
  for (std::size_t i = 2; i < n; ++i) mesh.triangles.push_back({i - 2, i, i - 1});
  return mesh;
}

bool same_as_floats(const Vec3& a, const Vec3& b) {
  return to_float(a) == to_float(b);
}

void write_mesh(const std::filesystem::path& path, const MeshContent& mesh, std::size_t chunk) {
  const auto writer = open_mesh_writer(path, mesh.positions.size(), mesh.triangles.size());
  const auto send = [chunk](auto elements, auto put) {
    for (std::size_t at = 0; at < elements.size(); at += chunk) {
      put(elements.subspan(at, std::min(chunk, elements.size() - at)));
    }
  };
  send(std::span(mesh.positions), [&](auto part) { writer->write_positions(part); });
  send(std::span(mesh.triangles), [&](auto part) { writer->write_triangles(part); });
  writer->close();
}

TEST_F(MeshWriter, ReaderReadsWhatItWrote) {
  // 87,381 positions and 80,659 triangles fill the buffer of a PLY.
  for (const std::size_t n :
       {0UL, 1UL, 2UL, 3UL, 8191UL, 8192UL, 8193UL, 80'661UL, 87'381UL, 200'000UL}) {
    const MeshContent mesh = sample_mesh(n);
    for (const std::string_view name : {"a.ply", "a.obj", "A.PLY", "a.off", "a.glb"}) {
      if (n == 0 && name == "a.obj") continue;
      if (n < 3 && name == "a.glb") continue;
      write_mesh(directory() / name, mesh, 5000);
      const MeshContent read = read_mesh(directory() / name);
      // The shortest text of a float reads as another double, but as the same float.
      EXPECT_TRUE(std::equal(read.positions.begin(), read.positions.end(), mesh.positions.begin(),
                             mesh.positions.end(), same_as_floats))
          << name << ' ' << n;
      EXPECT_TRUE(read.triangles == mesh.triangles) << name << ' ' << n;
    }
  }
}

TEST_F(MeshWriter, WritesPlainPly) {
  MeshContent mesh = sample_mesh(3);
  write_mesh(directory() / "a.ply", mesh, 100);
  std::string expected =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  for (const Vec3& p : mesh.positions) {
    for (const double c : {p.x, p.y, p.z}) append(expected, static_cast<float>(c));
  }
  append(expected, std::uint8_t{3});
  for (const std::int32_t v : {0, 2, 1}) append(expected, v);
  EXPECT_EQ(bytes_of(directory() / "a.ply"), expected);
}

TEST_F(MeshWriter, WritesTheShortestObj) {
  const auto writer = open_mesh_writer(directory() / "a.obj", 3, 1);
  writer->write_positions(std::vector<Vec3>{{0.1, -0.0, 1e-30}, {1, 2, 3}, {1e20, 0.5, 16777216}});
  writer->write_triangles(std::vector<Triangle>{{0, 1, 2}});
  writer->close();
  EXPECT_EQ(bytes_of(directory() / "a.obj"),
            "v 0.1 -0 1e-30\nv 1 2 3\nv 1e+20 0.5 16777216\nf 1 2 3\n");
}

TEST_F(MeshWriter, WidensIndicesWithTheNumberOfVertices) {
  // A mesh of these sizes is only begun: enough to push the header out of the buffer.
  const std::pair<std::uint64_t, std::string_view> cases[] = {{0x7FFFFFFFULL, "uchar int "},
                                                              {0x80000000ULL, "uchar uint "},
                                                              {0xFFFFFFFFULL, "uchar uint "},
                                                              {0x100000000ULL, "uchar uint64 "}};
  for (const auto& [vertices, list] : cases) {
    const auto writer = open_mesh_writer(directory() / "a.ply", vertices, 1);
    const std::vector<Vec3> chunk(100'000);
    writer->write_positions(chunk);
    std::string head;
    for (const auto& entry : std::filesystem::directory_iterator(directory())) {
      head = bytes_of(entry.path()).substr(0, 300);
    }
    EXPECT_NE(head.find(list), std::string::npos) << vertices;
  }
}

TEST_F(MeshWriter, KnowsItsExtensions) {
  EXPECT_TRUE(is_writable_mesh("a.ply"));
  EXPECT_TRUE(is_writable_mesh("dir.x/a.b.OBJ"));
  for (const std::string_view name : {"a.off", "a.stl", "a.GLB", "a.vtp"}) {
    EXPECT_TRUE(is_writable_mesh(name)) << name;
  }
  EXPECT_FALSE(is_writable_mesh("a.gltf"));
  EXPECT_FALSE(is_writable_mesh("ply"));
  EXPECT_FALSE(is_writable_mesh(".ply"));
  try {
    open_mesh_writer(directory() / "a.step", 0, 0);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string_view(error.what()).find(".ply, .obj"), std::string_view::npos);
  }
  EXPECT_EQ(files(), 0U);
}

TEST_F(MeshWriter, ShowsTheFileOnlyWhenClosed) {
  make_file("a.ply", "old");
  {
    const auto writer = open_mesh_writer(directory() / "a.ply", 1, 0);
    writer->write_positions(std::vector<Vec3>(1));
    EXPECT_EQ(bytes_of(directory() / "a.ply"), "old");
    const std::string partial = ".a.ply.partial-" + std::to_string(::getpid());
    EXPECT_TRUE(std::filesystem::exists(directory() / partial));
    writer->close();
    EXPECT_EQ(files(), 1U);
    EXPECT_EQ(read_mesh(directory() / "a.ply").positions.size(), 1U);
  }
  EXPECT_EQ(files(), 1U);
}

TEST_F(MeshWriter, LeavesNothingWhenNotClosed) {
  { open_mesh_writer(directory() / "a.ply", 1, 0)->write_positions(std::vector<Vec3>(1)); }
  EXPECT_EQ(files(), 0U);
}

TEST_F(MeshWriter, RefusesOtherCountsThanAnnounced) {
  const std::vector<Vec3> positions(4);
  const std::vector<Triangle> triangles(3, Triangle{0, 1, 2});
  for (const std::string_view name : {"a.ply", "a.obj", "a.off", "a.stl", "a.glb", "a.vtp"}) {
    const auto writer = open_mesh_writer(directory() / name, 3, 2);
    EXPECT_THROW(writer->write_positions(positions), Error);
    EXPECT_THROW(writer->write_triangles(std::span(triangles).first(1)), Error);
    writer->write_positions(std::span(positions).first(3));
    EXPECT_THROW(writer->close(), Error);
    EXPECT_THROW(writer->write_triangles(triangles), Error);
    writer->write_triangles(std::span(triangles).first(1));
    EXPECT_THROW(writer->close(), Error);
    EXPECT_FALSE(std::filesystem::exists(directory() / name));
    writer->write_triangles(std::span(triangles).first(1));
    writer->close();
    EXPECT_TRUE(std::filesystem::exists(directory() / name));
  }
}

TEST_F(MeshWriter, RefusesWhatItsReaderWouldRefuse) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto writer = open_mesh_writer(directory() / "a.ply", 3, 1);
  for (const double bad : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN(), 1e39,
                           3.4028235677973366e38}) {
    EXPECT_THROW(writer->write_positions(std::vector<Vec3>{{0, bad, 0}}), Error) << bad;
  }
  writer->write_positions(std::vector<Vec3>{{0, 3.4028235e38, 0}, {}, {}});
  EXPECT_THROW(writer->write_triangles(std::vector<Triangle>{{0, 1, 3}}), Error);
  writer->write_triangles(std::vector<Triangle>{{0, 1, 2}});
  writer->close();
  EXPECT_EQ(read_mesh(directory() / "a.ply").triangles.size(), 1U);
}

TEST_F(MeshWriter, ReportsWhatTheFileSystemRefuses) {
  EXPECT_THROW(open_mesh_writer(directory() / "absent" / "a.ply", 0, 0), IoError);
  std::filesystem::create_directory(directory() / "taken.ply");
  EXPECT_THROW(open_mesh_writer(directory() / "taken.ply", 0, 0)->close(), IoError);
  EXPECT_EQ(files(), 1U);
}

/// Lets no file of this process grow beyond a size, as a full disk would.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limited = {bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limited);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(MeshWriter, LeavesNothingOnAFullDisk) {
  const MeshContent mesh = sample_mesh(200'000);
  const MeshContent small = sample_mesh(10'000);
  for (const std::string_view name : {"a.ply", "a.obj", "a.off", "a.stl", "a.glb", "a.vtp"}) {
    SCOPED_TRACE(name);
    const FileSizeLimit limit(100'000);
    EXPECT_THROW(write_mesh(directory() / name, mesh, 5000), IoError);
    if (name == "a.stl") continue;  // its positions are on disk before its end
    // This one fits the buffer: closing is what fails, again and again.
    const auto writer = open_mesh_writer(directory() / name, 10'000, 1);
    writer->write_positions(small.positions);
    writer->write_triangles(std::vector<Triangle>{{0, 1, 2}});
    EXPECT_THROW(writer->close(), IoError);
    EXPECT_THROW(writer->close(), IoError);
    EXPECT_EQ(files(), 0U);
  }
}

}  // namespace
}  // namespace remaps
