#include "remaps/mesh/attributes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/remesh.h"
#include "support/attribute_files.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::AttributeLists;
using test::AttributeValues;
using test::MeshLists;

constexpr ScalarType kFloat = ScalarType::float32;

AttributeSpec scalar(const std::string& name, ScalarType type = kFloat,
                     AttributePer per = AttributePer::vertex) {
  const bool label = is_integer(type);
  return {name, label ? AttributeKind::label : AttributeKind::scalar, per, {{name, type}}, false};
}
AttributeSpec colour(ScalarType type) {
  return {"colour",
          AttributeKind::colour,
          AttributePer::vertex,
          {{"red", type}, {"green", type}, {"blue", type}},
          false};
}
AttributeSpec normal() {
  return {"normal",
          AttributeKind::normal,
          AttributePer::vertex,
          {{"nx", kFloat}, {"ny", kFloat}, {"nz", kFloat}},
          false};
}
AttributeSpec corner_uv() {
  return {"uv", AttributeKind::uv, AttributePer::corner, {{"u", kFloat}, {"v", kFloat}}, false};
}

double coordinate(const Vec3& p, std::size_t axis) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

class AttributesTest : public test::TempFiles {
 protected:
  RemeshOptions options(const std::string& input = "in.ply") const {
    return test::remesh_options(directory(), directory() / input);
  }
  static Report run(const RemeshOptions& options) {
    Progress progress;
    return remesh(options, progress);
  }
  Report resample(const RemeshOptions& made, const std::filesystem::path& output,
                  const AttributeChoice& choice = {}) const {
    ResampleBundleOptions o;
    o.bundle = made.bundle;
    o.output = output;
    o.level = made.level;
    o.threads = 1;
    o.memory_bytes = 24 << 20;
    o.measure = false;
    o.attributes = choice;
    Progress progress;
    return resample_bundle(o, progress);
  }
};

/// Two numbers that should be equal but for rounding to floats, of things as large as `size`.
constexpr double kRounding = 4 * 0x1p-24;

/// The coordinates themselves as attributes.
class Coordinates : public AttributesTest,
                    public testing::WithParamInterface<std::tuple<BaseShape, bool>> {
 protected:
  MeshLists put() const {
    const MeshLists mesh = test::scan(std::get<0>(GetParam()), 6'000, true);
    write_with_attributes(mesh, {scalar("px"), colour(kFloat), scalar("pz", ScalarType::float64)},
                          {[&](std::size_t v, std::size_t c) {
                             const Vec3& p = mesh.position[v];
                             return c == 0 ? p.x : c == 4 ? p.z : coordinate(p, c - 1);
                           },
                           {},
                           {}},
                          directory() / "in.ply");
    return mesh;
  }
  RemeshOptions job() const {
    RemeshOptions o = options();
    o.level = 4;
    if (std::get<1>(GetParam())) o.domain_buffer = test::kSmallDomainBuffer;
    return o;
  }
};

TEST_P(Coordinates, AreThoseOfTheOutput) {
  const MeshLists input = put();
  const RemeshOptions o = job();
  const Report report = run(o);
  if (std::get<1>(GetParam())) {
    EXPECT_GT(report.sweeps[0].segments, 1u);
  }
  double size = 0;
  for (const Vec3& p : input.position)
    size = std::max({size, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  const MeshLists output = test::read_lists(o.output);
  const AttributeLists attributes = test::read_attributes(o.output);
  ASSERT_EQ(attributes.specs.size(), 3u);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = attributes.column("colour", axis);
    ASSERT_EQ(found.size(), output.position.size());
    for (std::size_t v = 0; v < found.size(); ++v) {
      ASSERT_NEAR(found[v], coordinate(output.position[v], axis), kRounding * size) << v;
    }
  }
  EXPECT_EQ(attributes.column("px"), attributes.column("colour", 0));
  const auto z = attributes.column("pz");
  for (std::size_t v = 0; v < z.size(); ++v) {
    ASSERT_NEAR(z[v], output.position[v].z, kRounding * size);
  }
  EXPECT_NO_THROW({
    QueryOptions query;
    query.bundle = o.bundle;
    query.temp_dir = directory();
    Progress progress;
    verify_bundle(query, progress);
  });
}

TEST_P(Coordinates, AreTheSameBytesForAnyThreadsAndMemoryAndFromTheBundle) {
  put();
  std::map<std::string, std::string> first;
  for (const unsigned threads : {1u, 3u}) {
    for (const std::uint64_t mib : {24u, 200u}) {
      RemeshOptions o = job();
      o.domain_buffer = test::kSmallDomainBuffer;
      o.threads = threads;
      o.memory_bytes = mib << 20;
      run(o);
      resample(o, directory() / "again.ply");
      EXPECT_TRUE(bytes_of(directory() / "again.ply") == bytes_of(o.output));
      const std::map<std::string, std::string> made = {
          {"output", bytes_of(o.output)},
          {"attributes", bytes_of(o.bundle / kAttributesName)},
          {"manifest", bytes_of(o.bundle / kManifestName)}};
      if (first.empty()) first = made;
      for (const auto& [name, bytes] : made) {
        EXPECT_TRUE(bytes == first[name]) << name << ", " << threads << " threads, " << mib;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Coordinates,
                         testing::Combine(testing::Values(BaseShape::kTorus, BaseShape::kDisk),
                                          testing::Bool()));

TEST_F(AttributesTest, ColoursAreRoundedAndNormalsHaveLengthOne) {
  const MeshLists mesh = test::scan(BaseShape::kIcosahedron, 5'000);
  write_with_attributes(mesh, {normal(), colour(ScalarType::uint8), scalar("zero")},
                        {[&](std::size_t v, std::size_t c) {
                           const Vec3& p = mesh.position[v];
                           if (c < 3) return p.x > 0 ? coordinate(p, c) / norm(p) : 0.0;
                           return c == 6 ? 0.0 : 127.5 + 100 * coordinate(p, c - 3);
                         },
                         {},
                         {}},
                        directory() / "in.ply");
  RemeshOptions o = options();
  o.level = 3;
  run(o);
  const MeshLists output = test::read_lists(o.output);
  const AttributeLists found = test::read_attributes(o.output);
  ASSERT_NE(found.find("colour"), nullptr);
  EXPECT_EQ(*found.find("colour"), colour(ScalarType::uint8));
  std::size_t zero = 0;
  for (std::size_t v = 0; v < output.position.size(); ++v) {
    const Vec3& p = output.position[v];
    Vec3 n{found.column("normal", 0)[v], found.column("normal", 1)[v],
           found.column("normal", 2)[v]};
    if (p.x < -0.2) {
      EXPECT_EQ(n, Vec3{});
      ++zero;
    } else if (p.x > 0.2) {
      ASSERT_NEAR(norm(n), 1, 1e-6);
      ASSERT_GT(dot(n, p), 0.99 * norm(p));
    }
    if (v % 97 != 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      // Rounded on the input and on the output.
      ASSERT_NEAR(found.column("colour", c)[v], 127.5 + 100 * coordinate(p, c), 1.001);
    }
  }
  EXPECT_GT(zero, 10u);
}

TEST_F(AttributesTest, LabelsAreNeverMixed) {
  const MeshLists mesh = test::scan(BaseShape::kTorus, 5'000);
  const auto label_at = [](const Vec3& p) {
    return p.x < 0 ? -1'000'000 : p.y < 0 ? 7 : 2'000'000;
  };
  const auto centre = [&](const MeshLists& m, std::size_t f) {
    const Triangle& t = m.triangle[f];
    return (1.0 / 3) * (m.position[t[0]] + m.position[t[1]] + m.position[t[2]]);
  };
  write_with_attributes(
      mesh,
      {scalar("part", ScalarType::int32), scalar("segment", ScalarType::int32, AttributePer::face),
       scalar("heat", kFloat, AttributePer::face)},
      {[&](std::size_t v, std::size_t) { return double(label_at(mesh.position[v])); },
       [&](std::size_t f, std::size_t c) {
         return c == 0 ? double(label_at(centre(mesh, f))) : double(f);
       },
       {}},
      directory() / "in.ply");
  RemeshOptions o = options();
  o.domain_buffer = test::kSmallDomainBuffer;
  o.level = 3;
  run(o);
  const MeshLists output = test::read_lists(o.output);
  const AttributeLists found = test::read_attributes(o.output);
  const auto part = found.column("part");
  const auto segment = found.column("segment");
  const auto heat = found.column("heat");
  ASSERT_EQ(part.size(), output.position.size());
  ASSERT_EQ(segment.size(), output.triangle.size());
  std::size_t wrong = 0;
  for (std::size_t v = 0; v < part.size(); ++v) {
    ASSERT_TRUE(part[v] == -1'000'000 || part[v] == 7 || part[v] == 2'000'000) << part[v];
    wrong += part[v] != label_at(output.position[v]);
  }
  EXPECT_LT(double(wrong), 0.05 * double(part.size()));
  wrong = 0;
  for (std::size_t f = 0; f < segment.size(); ++f) {
    ASSERT_TRUE(segment[f] == -1'000'000 || segment[f] == 7 || segment[f] == 2'000'000);
    wrong += segment[f] != label_at(centre(output, f));
    // A number of a face, whole: this face is near.
    ASSERT_EQ(heat[f], std::round(heat[f]));
    const auto near = static_cast<std::size_t>(heat[f]);
    ASSERT_LT(near, mesh.triangle.size());
    ASSERT_LT(norm(centre(mesh, near) - centre(output, f)), 0.2);
  }
  EXPECT_LT(double(wrong), 0.05 * double(segment.size()));
}

TEST_F(AttributesTest, TextureCoordinatesOfCornersAreExactWhereThereIsNoSeam) {
  const MeshLists mesh = test::scan(BaseShape::kDisk, 5'000);
  write_with_attributes(mesh, {corner_uv()},
                        {{},
                         {},
                         [&](std::size_t i, std::size_t c) {
                           return coordinate(mesh.position[mesh.triangle[i / 3][i % 3]], c);
                         }},
                        directory() / "in.ply");
  RemeshOptions o = options();
  o.domain_buffer = test::kSmallDomainBuffer;
  run(o);
  const MeshLists output = test::read_lists(o.output);
  const AttributeLists found = test::read_attributes(o.output);
  ASSERT_EQ(found.specs, std::vector{corner_uv()});
  ASSERT_EQ(found.corner.size(), 6 * output.triangle.size());
  for (std::size_t i = 0; i < 3 * output.triangle.size(); ++i) {
    const Vec3& p = output.position[output.triangle[i / 3][i % 3]];
    ASSERT_NEAR(found.corner[2 * i], p.x, 3e-6);
    ASSERT_NEAR(found.corner[2 * i + 1], p.y, 3e-6);
  }
}

TEST_F(AttributesTest, TextureCoordinatesAreNotSmearedAcrossASeam) {
  // Two charts far apart: the half with x < 0, and the other. The map is an isometry within each.
  const MeshLists mesh = test::scan(BaseShape::kDisk, 8'000);
  const auto chart = [](const Vec3& p) { return p.x < 0 ? 50.0 : 0.0; };
  write_with_attributes(mesh, {corner_uv()},
                        {{},
                         {},
                         [&](std::size_t i, std::size_t c) {
                           const Triangle& t = mesh.triangle[i / 3];
                           const Vec3 centre =
                               (1.0 / 3) *
                               (mesh.position[t[0]] + mesh.position[t[1]] + mesh.position[t[2]]);
                           return coordinate(mesh.position[t[i % 3]], c) + chart(centre);
                         }},
                        directory() / "in.ply");
  RemeshOptions o = options();
  o.level = 3;
  for (const char* name : {"out.ply", "out.obj"}) {
    o.output = directory() / name;
    run(o);
    const MeshLists output = test::read_lists(o.output);
    std::vector<double> uv = test::read_attributes(o.output).corner;
    if (std::string(name) == "out.obj") {
      uv.clear();
      const auto reader = open_mesh_reader(o.output);
      reader->read_positions([](std::span<const Vec3>) {});
      ASSERT_EQ(reader->attributes().size(), 1u);
      reader->read_pool(
          0, [&](std::span<const double> rows) { uv.insert(uv.end(), rows.begin(), rows.end()); });
    }
    ASSERT_EQ(uv.size(), 6 * output.triangle.size());
    std::size_t on_seam = 0;
    for (std::size_t f = 0; f < output.triangle.size(); ++f) {
      bool near = false;
      double offset = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = output.position[output.triangle[f][k]];
        const double here = uv[6 * f + 2 * k] - p.x;
        // The surface is bumpy, and what is continued across the seam is an input triangle's plane.
        ASSERT_LT(std::min(std::fabs(here), std::fabs(here - 50)), 0.05);
        ASSERT_NEAR(uv[6 * f + 2 * k + 1] - p.y, here, 0.1);
        if (k == 0) offset = here;
        near |= std::fabs(here - offset) > 1;
        on_seam += (here > 25) != (p.x < 0);
      }
      // All three corners are of one chart.
      EXPECT_FALSE(near) << f;
    }
    EXPECT_GT(on_seam, 10u) << "no face lies across the seam: the test tests nothing";
  }
}

TEST_F(AttributesTest, WithoutAnyNothingIsDifferent) {
  const MeshLists mesh = test::scan(BaseShape::kTorus, 5'000);
  write_lists(mesh, directory() / "plain.ply");
  write_with_attributes(mesh, {scalar("w"), scalar("m", ScalarType::int32, AttributePer::face)},
                        {[](std::size_t v, std::size_t) { return double(v); },
                         [](std::size_t f, std::size_t) { return double(f); },
                         {}},
                        directory() / "in.ply");
  RemeshOptions plain = options("plain.ply");
  run(plain);
  const std::string expected = bytes_of(plain.output);
  EXPECT_FALSE(std::filesystem::exists(plain.bundle / kAttributesName));
  EXPECT_EQ(bytes_of(plain.bundle / kManifestName).find("attributes"), std::string::npos);
  const std::string map = bytes_of(plain.bundle / kMapName);

  RemeshOptions none = options();
  none.attributes = AttributeChoice("none");
  EXPECT_TRUE(run(none).attributes.empty());
  EXPECT_TRUE(bytes_of(none.output) == expected);
  EXPECT_FALSE(std::filesystem::exists(none.bundle / kAttributesName));

  RemeshOptions all = options();
  EXPECT_EQ(run(all).attributes.size(), 2u);
  EXPECT_TRUE(bytes_of(all.bundle / kMapName) == map);
  resample(all, directory() / "bare.ply", AttributeChoice("none"));
  EXPECT_TRUE(bytes_of(directory() / "bare.ply") == expected);
}

TEST_F(AttributesTest, OnlyThoseThatAreNamedAreCarried) {
  const MeshLists mesh = test::scan(BaseShape::kTorus, 5'000);
  write_with_attributes(
      mesh, {scalar("a"), normal(), scalar("b", ScalarType::uint16)},
      {[](std::size_t v, std::size_t c) { return c == 4 ? double(v) : 1.0; }, {}, {}},
      directory() / "in.ply");
  RemeshOptions o = options();
  o.attributes = AttributeChoice("b,a");
  const Report report = run(o);
  ASSERT_EQ(report.attributes.size(), 2u);
  EXPECT_EQ(report.attributes[0].name, "a");
  EXPECT_EQ(report.attributes[1].name, "b");
  AttributeLists found = test::read_attributes(o.output);
  ASSERT_EQ(found.specs.size(), 2u);
  EXPECT_EQ(found.specs[1], scalar("b", ScalarType::uint16));
  const auto b = found.column("b");

  resample(o, directory() / "b.ply", AttributeChoice("b"));
  found = test::read_attributes(directory() / "b.ply");
  ASSERT_EQ(found.specs.size(), 1u);
  EXPECT_EQ(found.column("b"), b);
  EXPECT_THROW(resample(o, directory() / "no.ply", AttributeChoice("normal")), InputError);
  o.attributes = AttributeChoice("a,other");
  try {
    run(o);
    ADD_FAILURE() << "carried what is not there";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no attribute 'other'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("a, normal, b"), std::string::npos);
  }
}

TEST_F(AttributesTest, ObjTakesWhatItCanHold) {
  const MeshLists mesh = test::scan(BaseShape::kTorus, 5'000);
  write_with_attributes(
      mesh, {colour(ScalarType::uint8), scalar("a"), normal()},
      {[&](std::size_t v, std::size_t c) {
         return c < 3 ? 51.0 * double(c) : c == 3 ? 9.0 : c == 4 + v % 1 ? 1.0 : 0.0;
       },
       {},
       {}},
      directory() / "in.ply");
  RemeshOptions o = options();
  o.output = directory() / "out.obj";
  const Report report = run(o);
  ASSERT_EQ(report.attributes.size(), 3u);
  EXPECT_TRUE(report.attributes[0].written);
  EXPECT_FALSE(report.attributes[1].written);
  EXPECT_TRUE(report.attributes[2].written);
  const AttributeLists found = test::read_attributes(o.output);
  ASSERT_EQ(found.specs.size(), 2u);
  EXPECT_TRUE(found.specs[1].pooled);
  ASSERT_EQ(found.vertex.size(), 3 * report.output_vertices);
  for (std::size_t i = 0; i < found.vertex.size(); ++i) {
    ASSERT_NEAR(found.vertex[i], 0.2 * double(i % 3), 1e-7);
  }
  // And back: the normals of corners become those of vertices again.
  RemeshOptions again = options();
  again.input = o.output;
  again.level = 1;
  again.output = directory() / "again.ply";
  run(again);
  const AttributeLists back = test::read_attributes(again.output);
  ASSERT_NE(back.find("normal"), nullptr);
  for (const double x : back.column("normal", 0)) ASSERT_NEAR(x, 1, 1e-6);
}

/// A grid with a fin of faces along one of its rows, some faces turned, one of them twice, and a
/// hole.
MeshLists dirty_grid() {
  constexpr VertexId kSide = 40;
  MeshLists mesh;
  const auto at = [](VertexId x, VertexId y) { return y * kSide + x; };
  for (VertexId y = 0; y < kSide; ++y) {
    for (VertexId x = 0; x < kSide; ++x) {
      mesh.position.push_back({double(x), double(y), double(x * x + y * y) / 64});
    }
  }
  for (VertexId y = 0; y + 1 < kSide; ++y) {
    for (VertexId x = 0; x + 1 < kSide; ++x) {
      mesh.triangle.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.triangle.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  for (VertexId x = 10; x < 30; ++x) {
    const VertexId top = mesh.position.size();
    mesh.position.push_back({double(x), 15, 60});
    if (x == 10) continue;
    mesh.triangle.push_back({at(x - 1, 15), at(x, 15), top - 1});
    mesh.triangle.push_back({at(x, 15), top, top - 1});
  }
  for (const std::size_t f : {300u, 301u, 302u, 900u}) {
    std::swap(mesh.triangle[f][0], mesh.triangle[f][1]);
  }
  mesh.triangle.push_back(mesh.triangle[7]);
  mesh.triangle.erase(mesh.triangle.begin() + 2000, mesh.triangle.begin() + 2002);
  return mesh;
}

TEST_F(AttributesTest, RepairLosesNone) {
  const MeshLists mesh = dirty_grid();
  write_with_attributes(
      mesh, {scalar("px"), scalar("py"), scalar("pz"), corner_uv()},
      {[&](std::size_t v, std::size_t c) { return coordinate(mesh.position[v], c); },
       {},
       [&](std::size_t i, std::size_t c) {
         return coordinate(mesh.position[mesh.triangle[i / 3][i % 3]], c);
       }},
      directory() / "in.ply");
  for (const std::uint64_t holes : {0u, 10u}) {
    for (const std::uint64_t buffer : {std::uint64_t{0}, std::uint64_t{1500}}) {
      RemeshOptions o = options();
      o.level = 3;
      o.fill_holes = holes;
      o.domain_buffer = buffer;
      const Report report = run(o);
      EXPECT_GT(report.repairs.split_vertices, 10u);
      EXPECT_GT(report.repairs.flipped_faces, 0u);
      EXPECT_TRUE(std::filesystem::exists(o.bundle / kCopiesName));
      const MeshLists output = test::read_lists(o.output);
      const AttributeLists found = test::read_attributes(o.output);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto values = found.column(axis == 0 ? "px" : axis == 1 ? "py" : "pz");
        ASSERT_EQ(values.size(), output.position.size());
        for (std::size_t v = 0; v < values.size(); ++v) {
          ASSERT_NEAR(values[v], coordinate(output.position[v], axis), 1e-4) << v;
        }
      }
      std::size_t without = 0;
      for (std::size_t i = 0; i < 3 * output.triangle.size(); ++i) {
        const Vec3& p = output.position[output.triangle[i / 3][i % 3]];
        const double u = found.corner[2 * i], v = found.corner[2 * i + 1];
        // Where a hole was filled there is no texture but that of the rim, which goes on for a
        // face.
        if (holes > 0 && (std::fabs(u - p.x) > 1e-4 || std::fabs(v - p.y) > 1e-4)) {
          ++without;
        } else {
          ASSERT_NEAR(u, p.x, 1e-4);
          ASSERT_NEAR(v, p.y, 1e-4);
        }
      }
      EXPECT_LT(without, 200u);
    }
  }
}

TEST_F(AttributesTest, EachLevelCarriesWhatItWouldCarryAlone) {
  const MeshLists mesh = test::scan(BaseShape::kDisk, 5'000);
  write_with_attributes(
      mesh, {scalar("w"), scalar("part", ScalarType::int32, AttributePer::face), corner_uv()},
      {[](std::size_t v, std::size_t) { return double(v); },
       [](std::size_t f, std::size_t) { return double(f); },
       [](std::size_t i, std::size_t c) { return double(i + c); }},
      directory() / "in.ply");
  for (const bool fit : {false, true}) {
    RemeshOptions o = options();
    o.level = 3;
    o.coarsest = 1;
    o.fit = fit;
    run(o);
    for (const unsigned level : {1u, 2u, 3u}) {
      RemeshOptions one = options();
      one.level = level;
      one.fit = fit;
      one.output = directory() / "one.ply";
      run(one);
      const auto path = directory() / ("out-l" + std::to_string(level) + ".ply");
      EXPECT_TRUE(bytes_of(one.output) == bytes_of(path)) << level;
    }
  }
}

TEST_F(AttributesTest, ADamagedFileOfThemIsFound) {
  const MeshLists mesh = test::scan(BaseShape::kTorus, 5'000);
  write_with_attributes(mesh, {scalar("a")},
                        {[](std::size_t v, std::size_t) { return double(v); }, {}, {}},
                        directory() / "in.ply");
  const RemeshOptions o = options();
  run(o);
  const auto path = o.bundle / kAttributesName;
  const std::string bytes = bytes_of(path);
  const auto check = [&] {
    QueryOptions query;
    query.bundle = o.bundle;
    query.temp_dir = directory();
    Progress progress;
    verify_bundle(query, progress);
  };
  EXPECT_NO_THROW(check());
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{30}, bytes.size() / 2, bytes.size() - 3}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    make_file("out.remaps/attributes.bin", damaged);
    EXPECT_THROW(check(), CorruptionError) << at;
    EXPECT_THROW(resample(o, directory() / "no.ply"), CorruptionError) << at;
  }
  std::filesystem::remove(path);
  EXPECT_THROW(check(), CorruptionError);
}

}  // namespace
}  // namespace remaps::pipeline
