#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::MeshLists;

/// Jobs that end early: they throw the right thing and leave nothing but the input.
class RemeshRefusal : public test::TempFiles {
 protected:
  std::filesystem::path put(const MeshLists& mesh) const {
    test::write_lists(mesh, directory() / "in.ply");
    return directory() / "in.ply";
  }
  RemeshOptions options(const std::filesystem::path& input) const {
    return test::remesh_options(directory(), input);
  }
  template <class Error>
  std::string message_of(const RemeshOptions& options) const {
    try {
      Progress progress;
      remesh(options, progress);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(entries_in(directory()), 1u) << "something is left behind";
      return error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "another exception: " << error.what();
    }
    return {};
  }
  /// Expects a GeometryError that names all the vertices, in one segment and in several.
  void expect_refused(const MeshLists& mesh, const std::vector<VertexId>& vertices) const {
    for (const std::uint64_t domain_buffer : {std::uint64_t{100'000}, std::uint64_t{600}}) {
      RemeshOptions o = options(put(mesh));
      o.domain_buffer = domain_buffer;
      o.base_vertices = 50;
      o.threads = 2;
      o.strict = true;
      const std::string message = message_of<GeometryError>(o);
      for (const VertexId v : vertices) {
        EXPECT_NE(message.find(fmt::format(" {} ", v)), std::string::npos)
            << message << "\nlacks vertex " << v;
      }
      EXPECT_NE(message.find("in.ply"), std::string::npos) << message;
    }
  }
  static MeshLists ball() { return test::lists_of(test::bumpy(test::icosphere(3), 0.05, 0.01, 1)); }
};

/// No file may grow beyond a size while this lives: writes fail as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(RemeshRefusal, TheSurfaceMayBeRefusedWhenItIsCounted) {
  RemeshOptions o = options(put(test::scan(BaseShape::kTorus, 3000)));
  o.domain_buffer = 600;  // several sweeps
  Topology counted;
  unsigned calls = 0;
  o.accept = [&](const Topology& topology) {
    counted = topology;
    ++calls;
    throw GeometryError("not this one");
  };
  EXPECT_EQ(message_of<GeometryError>(o), "not this one");
  EXPECT_EQ(calls, 1u);
  EXPECT_EQ(counted.components, 1u);
  EXPECT_EQ(counted.boundary_loops, 0u);
  EXPECT_EQ(counted.euler_characteristic(), 0);
}

TEST_F(RemeshRefusal, NamesAnEdgeWithThreeFaces) {
  MeshLists mesh = ball();
  const Triangle t = mesh.triangle[700];
  mesh.position.push_back({2, 2, 2});
  mesh.triangle.push_back({t[0], t[1], mesh.position.size() - 1});
  expect_refused(mesh, {t[0], t[1]});
}

TEST_F(RemeshRefusal, NamesAVertexWithTwoFans) {
  MeshLists mesh = ball();
  mesh.position.push_back({2, 2, 2});
  mesh.position.push_back({2, 3, 2});
  mesh.triangle.push_back({17, mesh.position.size() - 2, mesh.position.size() - 1});
  expect_refused(mesh, {17});
}

TEST_F(RemeshRefusal, NamesTheEdgeOfAFaceTheOtherWayRound) {
  MeshLists mesh = ball();
  std::swap(mesh.triangle[321][0], mesh.triangle[321][1]);
  const std::set<VertexId> corners(mesh.triangle[321].begin(), mesh.triangle[321].end());
  for (const std::uint64_t domain_buffer : {100'000u, 600u}) {
    RemeshOptions o = options(put(mesh));
    o.domain_buffer = domain_buffer;
    o.strict = true;
    const std::string message = message_of<GeometryError>(o);
    std::size_t named = 0;
    for (const VertexId v : corners)
      named += message.find(fmt::format(" {} ", v)) != std::string::npos;
    EXPECT_EQ(named, 2u) << message;
  }
}

TEST_F(RemeshRefusal, NamesTheVertexThatAFaceUsesTwice) {
  MeshLists mesh = ball();
  mesh.triangle[100][1] = mesh.triangle[100][0];
  expect_refused(mesh, {mesh.triangle[100][0]});
}

TEST_F(RemeshRefusal, RefusesAFaceThatComesTwice) {
  MeshLists mesh = ball();
  mesh.triangle.push_back(mesh.triangle[5]);
  RemeshOptions o = options(put(mesh));
  o.strict = true;
  EXPECT_NE(message_of<GeometryError>(o), "");
}

TEST_F(RemeshRefusal, RefusesAMeshWithoutFaces) {
  MeshLists mesh = ball();
  mesh.triangle.clear();
  EXPECT_NE(message_of<GeometryError>(options(put(mesh))), "");
  mesh.position.clear();
  EXPECT_NE(message_of<GeometryError>(options(put(mesh))), "");
}

TEST_F(RemeshRefusal, SaysThatTheBudgetIsTooSmall) {
  RemeshOptions o = options(put(ball()));
  o.memory_bytes = 10 << 20;
  EXPECT_NE(message_of<BudgetError>(o).find("24M"), std::string::npos);
  o = options(put(ball()));
  o.domain_buffer = 2000;
  o.base_vertices = 1001;
  EXPECT_NE(message_of<BudgetError>(o).find("1001 base vertices"), std::string::npos);
}

TEST_F(RemeshRefusal, RefusesMissingAndMalformedInput) {
  const auto path = make_file("in.ply", "ply\nformat ascii 1.0\nend_of_it\n");
  EXPECT_NE(message_of<InputError>(options(path)), "");
  RemeshOptions o = options(directory() / "absent.ply");
  EXPECT_NE(message_of<InputError>(o).find("absent.ply"), std::string::npos);
}

TEST_F(RemeshRefusal, RefusesPlacesThatCannotBeWrittenTo) {
  RemeshOptions o = options(put(ball()));
  o.output = directory() / "absent" / "out.ply";
  EXPECT_NE(message_of<IoError>(o), "");
  o = options(o.input);
  o.temp_dir = directory() / "absent";
  EXPECT_NE(message_of<IoError>(o), "");
  o = options(o.input);
  o.output = directory() / "out.xyz";
  EXPECT_NE(message_of<InputError>(o), "");
}

TEST_F(RemeshRefusal, LeavesADirectoryAloneThatIsNoBundle) {
  RemeshOptions o = options(put(ball()));
  std::filesystem::create_directory(o.bundle);
  test::write_lists(ball(), o.bundle / "precious.ply");
  Progress progress;
  EXPECT_THROW(remesh(o, progress), IoError);
  EXPECT_TRUE(std::filesystem::exists(o.bundle / "precious.ply"));
  EXPECT_FALSE(std::filesystem::exists(o.output));
  EXPECT_EQ(entries_in(directory()), 2u);
}

TEST_F(RemeshRefusal, ReplacesAnEarlierBundleAndOutput) {
  RemeshOptions o = options(put(ball()));
  Progress progress;
  remesh(o, progress);
  const std::string first = bytes_of(o.output);
  o.base_vertices = 40;
  remesh(o, progress);
  EXPECT_FALSE(bytes_of(o.output) == first);
  EXPECT_EQ(Bundle(o.bundle).base().position.size(), 40u);
  EXPECT_EQ(entries_in(directory()), 3u);
}

TEST_F(RemeshRefusal, LeavesNothingWhenCancelledInAnyPhase) {
  RemeshOptions o = options(put(test::scan(BaseShape::kTorus, 4'000)));
  o.domain_buffer = test::kSmallDomainBuffer;
  o.measure = true;
  o.samples = 2'000;
  std::vector<std::string> phases;
  {
    Progress progress([&](std::string_view phase, double) {
      if (phases.empty() || phases.back() != phase) phases.emplace_back(phase);
    });
    remesh(o, progress);
    std::filesystem::remove(o.output);
    std::filesystem::remove_all(o.bundle);
  }
  ASSERT_GE(phases.size(), 5u);
  for (const std::string& where : phases) {
    for (const unsigned threads : {1u, 3u}) {
      SCOPED_TRACE(where + ", " + std::to_string(threads) + " threads");
      o.threads = threads;
      Progress* running = nullptr;
      Progress progress([&](std::string_view phase, double fraction) {
        if (phase == where && fraction > 0) running->cancel();
      });
      running = &progress;
      EXPECT_THROW(remesh(o, progress), Cancelled);
      EXPECT_EQ(entries_in(directory()), 1u) << "something is left behind";
      std::filesystem::remove(o.output);
      std::filesystem::remove_all(o.bundle);
    }
  }
}

TEST_F(RemeshRefusal, LeavesNothingWhenAWriteFails) {
  RemeshOptions o = options(put(test::scan(BaseShape::kIcosahedron, 8'000)));
  o.domain_buffer = test::kSmallDomainBuffer;
  o.level = 4;
  Progress unlimited;
  remesh(o, unlimited);
  const auto output_bytes = std::filesystem::file_size(o.output);
  std::filesystem::remove(o.output);
  std::filesystem::remove_all(o.bundle);
  for (const std::uint64_t limit :
       {std::uint64_t{1'000}, std::uint64_t{60'000}, std::uint64_t{120'000}, output_bytes - 1}) {
    SCOPED_TRACE(std::to_string(limit) + " bytes");
    for (const unsigned threads : {1u, 2u}) {
      o.threads = threads;
      const FileSizeLimit disk(limit);
      Progress progress;
      EXPECT_THROW(remesh(o, progress), IoError);
      EXPECT_EQ(entries_in(directory()), 1u) << "something is left behind";
    }
  }
  const FileSizeLimit disk(64 << 20);
  EXPECT_NO_THROW(remesh(o, unlimited));
}

TEST_F(RemeshRefusal, KeepsAnOldOutputWhenARunFails) {
  RemeshOptions o = options(put(ball()));
  Progress progress;
  remesh(o, progress);
  const std::string output = bytes_of(o.output);
  const std::string manifest = bytes_of(o.bundle / kManifestName);
  o.base_vertices = 40;
  Progress cancelled;
  cancelled.cancel();
  EXPECT_THROW(remesh(o, cancelled), Cancelled);
  EXPECT_TRUE(bytes_of(o.output) == output);
  EXPECT_TRUE(bytes_of(o.bundle / kManifestName) == manifest);
}

}  // namespace
}  // namespace remaps::pipeline
