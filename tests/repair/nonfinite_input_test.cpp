#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "pipeline/welded_lists.h"
#include "remaps/base/errors.h"
#include "remaps/pipeline/check.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/surface_check.h"
#include "support/temp_files.h"

/// Vertices that are not finite go with their faces: what is left is treated as if these faces had
/// never been there.
namespace remaps::pipeline {
namespace {

using test::MeshLists;

class NonfiniteInput : public test::TempFiles {
 protected:
  /// A binary PLY, which is read in place, or text.
  std::filesystem::path write(const MeshLists& mesh, const std::string& name) const {
    const std::filesystem::path path = directory() / name;
    std::ofstream out(path, std::ios::binary);
    const bool text = path.extension() == ".obj";
    if (!text) {
      out << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.position.size()
          << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
          << mesh.triangle.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    }
    out.precision(9);
    for (const Vec3& p : mesh.position) {
      const Vec3f q = to_float(p);
      if (text) {
        out << "v " << q.x << ' ' << q.y << ' ' << q.z << '\n';
      } else {
        out.write(reinterpret_cast<const char*>(&q), sizeof q);
      }
    }
    for (const Triangle& t : mesh.triangle) {
      if (text) {
        out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
        continue;
      }
      out.put(3);
      for (const VertexId v : t) {
        const auto index = static_cast<std::int32_t>(v);
        out.write(reinterpret_cast<const char*>(&index), sizeof index);
      }
    }
    return path;
  }

  struct Pair {
    MeshLists dirty, clean;  ///< the same vertices; clean lacks the faces
    std::vector<VertexId> wild;
  };

  /// Makes vertices not finite, single ones and runs.
  static Pair sprinkle(MeshLists mesh, std::uint64_t seed, std::size_t places) {
    std::mt19937_64 random(seed);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Pair pair;
    std::vector<bool> wild(mesh.position.size());
    for (std::size_t i = 0; i < places; ++i) {
      const VertexId first = random() % mesh.position.size();
      const VertexId end = std::min<VertexId>(first + (i % 8 == 0 ? 20 : 1), wild.size());
      for (VertexId v = first; v < end; ++v) {
        wild[v] = true;
        const double value = random() % 3 == 0   ? std::nan("")
                             : random() % 2 == 0 ? kInfinity
                                                 : -kInfinity;
        Vec3& p = mesh.position[v];
        (random() % 3 == 0 ? p.x : random() % 2 == 0 ? p.y : p.z) = value;
      }
    }
    for (VertexId v = 0; v < wild.size(); ++v) {
      if (wild[v]) pair.wild.push_back(v);
    }
    pair.dirty = mesh;
    pair.clean.position = mesh.position;
    for (const Triangle& t : mesh.triangle) {
      if (!wild[t[0]] && !wild[t[1]] && !wild[t[2]]) pair.clean.triangle.push_back(t);
    }
    return pair;
  }

  static std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  RemeshOptions options(const std::filesystem::path& input) const {
    return test::remesh_options(directory(), input);
  }

  MeshCheck checked(const std::filesystem::path& path, unsigned threads) const {
    CheckOptions options;
    options.input = path;
    options.temp_dir = directory();
    options.threads = threads;
    options.memory_bytes = 24 << 20;
    Progress progress;
    return check_mesh(options, progress);
  }

  static std::vector<std::uint32_t> map_faces(const std::filesystem::path& bundle) {
    const std::string bytes = bytes_of(bundle / "map.bin");
    std::vector<std::uint32_t> faces(bytes.size() / 12);
    for (std::size_t v = 0; v < faces.size(); ++v)
      std::memcpy(&faces[v], bytes.data() + 12 * v, sizeof faces[v]);
    return faces;
  }

  /// The bundle verifies, tells which vertices have no place, and its input can be measured.
  void check_bundle(const RemeshOptions& o, const Pair& pair) const {
    Progress progress;
    QueryOptions query;
    query.bundle = o.bundle;
    query.temp_dir = directory();
    query.memory_bytes = 24 << 20;
    query.threads = 1;
    EXPECT_NO_THROW(verify_bundle(query, progress));
    const std::vector<std::uint32_t> faces = map_faces(o.bundle);
    ASSERT_EQ(faces.size(), pair.dirty.position.size());
    for (const VertexId v : pair.wild) EXPECT_EQ(faces[v], 0xFFFFFFFFu);
    MeasureOptions measure;
    measure.original = o.input;
    measure.remesh = o.output;
    measure.samples = 2'000;
    measure.threads = 1;
    measure.memory_bytes = 64 << 20;
    measure.temp_dir = directory();
    const SurfaceError error = measure_files(measure, progress);
    EXPECT_LT(error.l2(), 0.1);
    EXPECT_GT(error.diagonal, 0);
  }

  /// Remeshes both at several cuts and numbers of threads: the outputs are the same, byte for byte.
  void expect_same_remesh(const Pair& pair, const std::string& extension) const {
    std::string first;
    for (const std::uint64_t buffer : {std::uint64_t{0}, test::kSmallDomainBuffer}) {
      for (const unsigned threads : {1u, 3u}) {
        SCOPED_TRACE(std::to_string(buffer) + " faces, " + std::to_string(threads) + " threads");
        RemeshOptions o = options(write(pair.dirty, "dirty" + extension));
        o.domain_buffer = buffer != 0 ? buffer : o.domain_buffer;
        o.threads = threads;
        Progress progress;
        const Report dirty = remesh(o, progress);
        const std::string dirty_bytes = bytes_of(o.output);
        EXPECT_EQ(dirty.repairs.nonfinite_vertices, pair.wild.size());
        EXPECT_EQ(dirty.repairs.nonfinite_faces,
                  pair.dirty.triangle.size() - pair.clean.triangle.size());
        EXPECT_EQ(dirty.input_faces, pair.dirty.triangle.size());
        check_bundle(o, pair);
        o.input = write(pair.clean, "clean" + extension);
        const Report clean = remesh(o, progress);
        EXPECT_EQ(clean.repairs.nonfinite_faces, 0u);
        EXPECT_EQ(clean.repairs.unreferenced_vertices, dirty.repairs.unreferenced_vertices);
        EXPECT_EQ(clean.repairs.split_vertices, dirty.repairs.split_vertices);
        EXPECT_EQ(clean.repairs.nonmanifold_vertices, dirty.repairs.nonmanifold_vertices);
        EXPECT_EQ(clean.bbox_diagonal, dirty.bbox_diagonal);
        EXPECT_TRUE(dirty_bytes == bytes_of(o.output));
        if (threads == 1) first = dirty_bytes;
        EXPECT_TRUE(dirty_bytes == first) << "threads make a difference";
        EXPECT_EQ(test::count_surface(test::read_lists(o.output).triangle).defect, "");
      }
    }
  }
};

TEST_F(NonfiniteInput, GoesWithItsFacesAndChangesNothingElse) {
  for (const std::uint64_t seed : {1u, 2u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Pair pair = sprinkle(
        test::scan(seed == 1 ? BaseShape::kTorus : BaseShape::kIcosahedron, 5'000, seed == 2), seed,
        40);
    expect_same_remesh(pair, ".ply");
    if (seed == 1) expect_same_remesh(pair, ".obj");
  }
}

/// Triangles among few vertices, most of them with something else wrong too.
TEST_F(NonfiniteInput, IsFoundInSoups) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    MeshLists mesh;
    for (std::size_t v = 0; v < 40 + seed; ++v)
      mesh.position.push_back({double(random() % 1000), double(random() % 1000), double(v)});
    for (std::size_t f = 0; f < 60 + 5 * seed; ++f) {
      const auto n = mesh.position.size();
      mesh.triangle.push_back({random() % n, random() % n, random() % n});
    }
    const Pair pair = sprinkle(mesh, seed, 5);
    if (pair.clean.triangle.empty()) continue;
    std::uint64_t degenerate = 0;
    for (const Triangle& t : mesh.triangle)
      degenerate += t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    for (const unsigned threads : {1u, 3u}) {
      const MeshCheck dirty = checked(write(pair.dirty, "dirty.ply"), threads);
      const MeshCheck clean = checked(write(pair.clean, "clean.ply"), threads);
      EXPECT_EQ(dirty.repairs.nonfinite_vertices, pair.wild.size());
      EXPECT_EQ(dirty.repairs.degenerate_faces, degenerate);
      EXPECT_EQ(
          dirty.repairs.nonfinite_faces + dirty.repairs.degenerate_faces,
          clean.repairs.degenerate_faces + pair.dirty.triangle.size() - pair.clean.triangle.size());
      const std::size_t named = std::min<std::size_t>(pair.wild.size(), 5);
      EXPECT_EQ(dirty.nonfinite, std::vector<VertexId>(pair.wild.begin(),
                                                       pair.wild.begin() + std::ptrdiff_t(named)));
      EXPECT_EQ(dirty.defects.nonmanifold_edges, clean.defects.nonmanifold_edges);
      EXPECT_EQ(dirty.defects.nonmanifold_vertices, clean.defects.nonmanifold_vertices);
      EXPECT_EQ(dirty.defects.duplicate_faces, clean.defects.duplicate_faces);
      EXPECT_EQ(dirty.one_sided.empty(), clean.one_sided.empty());
      EXPECT_EQ(dirty.topology.faces, clean.topology.faces);
      EXPECT_EQ(dirty.topology.vertices, clean.topology.vertices);
      EXPECT_EQ(dirty.topology.boundary_loops, clean.topology.boundary_loops);
      EXPECT_FALSE(dirty.sound());
    }
  }
}

TEST_F(NonfiniteInput, IsNamedWhenStrict) {
  MeshLists mesh = test::scan(BaseShape::kIcosahedron, 3'000);
  mesh.position[mesh.triangle[77][1]].y = std::nan("");
  RemeshOptions o = options(write(mesh, "in.ply"));
  o.strict = true;
  FaceId face = 0;
  while (std::count(mesh.triangle[face].begin(), mesh.triangle[face].end(), mesh.triangle[77][1]) ==
         0)
    ++face;
  Progress progress;
  try {
    remesh(o, progress);
    ADD_FAILURE() << "was remeshed";
  } catch (const GeometryError& error) {
    const std::string message = error.what();
    for (const std::string& part :
         {std::string("in.ply"), "vertex " + std::to_string(mesh.triangle[77][1]),
          "face " + std::to_string(face), std::string("--strict")})
      EXPECT_NE(message.find(part), std::string::npos) << message;
  }
}

TEST_F(NonfiniteInput, IsRefusedWhenNothingElseIsThere) {
  MeshLists mesh = test::scan(BaseShape::kIcosahedron, 500);
  for (Vec3& p : mesh.position) p.z = std::numeric_limits<double>::infinity();
  for (const char* name : {"all.ply", "all.obj"}) {
    RemeshOptions o = options(write(mesh, name));
    Progress progress;
    try {
      remesh(o, progress);
      ADD_FAILURE() << "was remeshed";
    } catch (const GeometryError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  }
  mesh = test::scan(BaseShape::kIcosahedron, 500);
  for (const Triangle& t : mesh.triangle) mesh.position[t[0]].x = std::nan("");
  RemeshOptions o = options(write(mesh, "faces.ply"));
  Progress progress;
  EXPECT_THROW(remesh(o, progress), GeometryError);
}

/// Facets of an STL have vertices of their own: those of a dropped one go with it.
TEST_F(NonfiniteInput, TakesFacetsOfAnStlAlone) {
  const MeshLists mesh = test::scan(BaseShape::kIcosahedron, 3'000);
  const MeshLists soup = test::soup_of(mesh);
  test::write_lists(soup, directory() / "in.stl");
  std::string bytes = bytes_of(directory() / "in.stl");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::size_t facet : {0U, 1U, 500U, 501U, 4000U})
    std::memcpy(bytes.data() + 84 + 50 * facet + 12 + 12 * (facet % 3), &nan, sizeof nan);
  std::ofstream(directory() / "in.stl", std::ios::binary) << bytes;
  RemeshOptions o = options(directory() / "in.stl");
  Progress progress;
  const Report report = remesh(o, progress);
  EXPECT_EQ(report.repairs.nonfinite_vertices, 15u);
  EXPECT_EQ(report.repairs.nonfinite_faces, 5u);
  EXPECT_EQ(report.repairs.unreferenced_vertices, 0u);
  EXPECT_EQ(report.input_vertices, mesh.position.size() + 15);
  EXPECT_GT(report.boundary_loops, 0u);
  o.weld_distance = 1e-7;
  const Report near = remesh(o, progress);
  EXPECT_EQ(near.repairs.nonfinite_vertices, 15u);
  EXPECT_EQ(near.boundary_loops, report.boundary_loops);
}

/// Polygons go as a whole.
TEST_F(NonfiniteInput, TakesPolygonsAsAWhole) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 0 1 0\nv 1 -1 nan\n";
  for (const std::string polygon : {"7 1 2 3", "1 7 3 2", "3 2 1 7", "2 3 7 1"}) {
    const MeshCheck found =
        checked(make_file("quads.obj", vertices + "f 1 2 5 6\nf 2 3 4 5\nf " + polygon + "\n"), 1);
    EXPECT_EQ(found.faces, 6u);
    EXPECT_EQ(found.repairs.nonfinite_faces, 2u) << polygon;
    EXPECT_EQ(found.topology.faces, 4u);
  }
}

}  // namespace
}  // namespace remaps::pipeline
