#include "remaps/codec/archive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "codec/semi_regular_shapes.h"
#include "remaps/base/errors.h"
#include "remaps/pipeline/codec_files.h"
#include "remaps/store/file.h"

namespace remaps::codec {
namespace {

using test::decode;
using test::encode;
using test::kCodecMemory;
using test::rough_mesh;

constexpr Wavelet kWavelets[] = {Wavelet::kButterfly, Wavelet::kLiftedButterfly, Wavelet::kLoop};

SemiRegularMesh in_order(const SemiRegularMesh& mesh) {
  MemoryBudget budget(kCodecMemory);
  return in_coding_order(mesh, budget);
}

/// The sum of what all levels may be off by, tangentially too.
double error_bound(const ArchiveHeader& header) {
  double sum = 0;
  for (unsigned m = 0; m <= header.levels; ++m) {
    const double normal = header.quantization.step_of(m, 0);
    const double tangential = header.quantization.step_of(m, 1);
    sum += std::hypot(normal, tangential, tangential);
  }
  return sum;
}

TEST(Archive, DecodesWithinItsSteps) {
  for (const test::CodecBase& base : test::codec_bases()) {
    SCOPED_TRACE(base.name);
    for (unsigned levels = 0; levels <= 3; ++levels) {
      const SemiRegularMesh mesh = in_order(rough_mesh(base, levels, 0.02, 5));
      for (const Wavelet wavelet : kWavelets) {
        for (const unsigned planes : {1u, 8u, 14u, 24u}) {
          const store::Bytes bytes = encode(mesh, {.wavelet = wavelet, .bitplanes = planes});
          const Archive archive(bytes, "archive");
          EXPECT_TRUE(archive.complete());
          const SemiRegularMesh decoded = decode(bytes);
          EXPECT_EQ(decoded.base, mesh.base);
          EXPECT_EQ(decoded.levels, levels);
          EXPECT_LE(test::largest_distance(decoded, mesh), error_bound(archive.header()))
              << "level " << levels << ", " << planes << " planes";
        }
      }
    }
  }
}

TEST(Archive, DecodesEveryPrefix) {
  for (const test::Shape& shape : {test::octahedron(), test::cone(4), test::torus(3, 3)}) {
    SemiRegularMesh mesh = in_order(rough_mesh(test::base_of(shape), 2, 0.05, 6));
    test::add_signals(mesh);
    const store::Bytes bytes = encode(mesh);
    const Archive archive(bytes, "archive");
    for (std::uint64_t size = 0; size < archive.least_bytes(); ++size) {
      EXPECT_THROW(Archive(store::ByteSpan(bytes).first(size), "cut"), InputError) << size;
      EXPECT_THROW(decode(bytes, size), InputError) << size;
    }
    std::size_t signals = 0;
    for (std::uint64_t size = archive.least_bytes(); size <= bytes.size(); ++size) {
      const SemiRegularMesh decoded = decode(bytes, size);
      EXPECT_EQ(decoded.base, mesh.base);
      EXPECT_EQ(decoded.position.size(), mesh.position.size());
      EXPECT_TRUE(test::is_finite(decoded.position)) << size;
      EXPECT_GE(decoded.signals.size(), signals);
      signals = decoded.signals.size();
      for (const Signal& signal : decoded.signals) {
        EXPECT_EQ(signal.value.size(), mesh.position.size());
        EXPECT_TRUE(test::is_finite(signal.value)) << size;
      }
      // A file that ends there is the same.
      const SemiRegularMesh cut = decode(store::ByteSpan(bytes).first(size));
      EXPECT_EQ(cut.position, decoded.position) << size;
    }
    EXPECT_EQ(signals, 2u);
  }
}

TEST(Archive, CoarserLevelsHaveTheirVertices) {
  const SemiRegularMesh mesh = in_order(rough_mesh(test::base_of(test::annulus(5, 2)), 3, 0.05, 7));
  for (const Wavelet wavelet : kWavelets) {
    const store::Bytes bytes = encode(mesh, {.wavelet = wavelet, .bitplanes = 20});
    const Archive archive(bytes, "archive");
    MemoryBudget budget(kCodecMemory);
    const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, 3, budget);
    for (unsigned j = 0; j <= 3; ++j) {
      const SemiRegularMesh decoded = archive.decode(bytes.size(), j, budget);
      EXPECT_EQ(decoded.levels, j);
      ASSERT_EQ(decoded.position.size(), hierarchy.vertices(j));
      if (wavelet != Wavelet::kButterfly) continue;
      for (std::size_t v = 0; v < decoded.position.size(); ++v) {
        EXPECT_LE(norm(decoded.position[v] - mesh.position[v]), error_bound(archive.header()));
      }
    }
  }
}

TEST(Archive, OfADecodedMeshIsTheSameMesh) {
  for (const test::CodecBase& base : test::codec_bases()) {
    SCOPED_TRACE(base.name);
    for (const Wavelet wavelet : kWavelets) {
      const EncodeOptions options{.wavelet = wavelet, .bitplanes = 12};
      const store::Bytes bytes = encode(rough_mesh(base, 3, 0.02, 8), options);
      const SemiRegularMesh once = decode(bytes);
      const SemiRegularMesh twice = decode(encode(once, options));
      EXPECT_EQ(twice.base, once.base);
      const double step = Archive(bytes, "archive").header().quantization.step;
      EXPECT_LE(test::largest_distance(once, twice), 1e-6 * step);
    }
  }
}

TEST(Archive, KeepsItsPrecisionAtAnyScaleAndPlace) {
  const SemiRegularMesh unit = in_order(rough_mesh(test::base_of(test::icosphere(0)), 3, 0.02, 9));
  const store::Bytes of_unit = encode(unit);
  const double error = test::largest_distance(decode(of_unit), unit) / test::diagonal_of(unit);
  for (const double scale : {1e-30, 1e-6, 1e6, 1e30, 1e100}) {
    SemiRegularMesh mesh = unit;
    for (Vec3& p : mesh.position) p = scale * p;
    const store::Bytes bytes = encode(mesh);
    EXPECT_LE(test::largest_distance(decode(bytes), mesh), 2 * error * test::diagonal_of(mesh))
        << scale;
    EXPECT_LT(double(bytes.size()), 1.1 * double(of_unit.size())) << scale;
  }
  for (const double away : {1e3, 1e6, -1e9}) {
    SemiRegularMesh mesh = unit;
    for (Vec3& p : mesh.position) p = p + Vec3{away, -away, 0.5 * away};
    const store::Bytes bytes = encode(mesh);
    EXPECT_LE(test::largest_distance(decode(bytes), mesh), 2 * error * test::diagonal_of(mesh))
        << away;
    EXPECT_LT(double(bytes.size()), 1.1 * double(of_unit.size())) << away;
  }
}

TEST(Archive, TakesSurfacesWithoutDetails) {
  // Flat, all in one point, and all on a line.
  test::CodecBase flat = test::base_of(test::disk(2));
  for (Vec3& p : flat.position) p.z = 0;
  test::CodecBase point = flat, line = flat;
  for (Vec3& p : point.position) p = {3, 4, 5};
  for (Vec3& p : line.position) p = {p.x, 0, 0};
  for (const test::CodecBase& base : {flat, point, line}) {
    for (const Wavelet wavelet : kWavelets) {
      const SemiRegularMesh mesh = in_order(rough_mesh(base, 3, 0, 1));
      const store::Bytes bytes = encode(mesh, {.wavelet = wavelet});
      EXPECT_LE(test::largest_distance(decode(bytes), mesh),
                error_bound(Archive(bytes, "archive").header()));
    }
  }
}

/// Farther away than coordinates have bits for.
TEST(Archive, TakesSurfacesThatRoundToAPoint) {
  const SemiRegularMesh unit = rough_mesh(test::base_of(test::icosphere(0)), 2, 0.02, 9);
  for (const double away : {1e12, 1e15, 1e17, 1e100}) {
    SemiRegularMesh mesh = unit;
    for (Vec3& p : mesh.position) p = p + Vec3{away, -away, away};
    mesh = in_order(mesh);
    EXPECT_LE(test::largest_distance(decode(encode(mesh)), mesh), 1e-14 * away) << away;
  }
}

TEST(Archive, RefusesWhatIsNoSurface) {
  const SemiRegularMesh mesh = rough_mesh(test::base_of(test::octahedron()), 2, 0.05, 2);
  for (const double bad : {HUGE_VAL, -HUGE_VAL, double(NAN), 1e308}) {
    SemiRegularMesh broken = mesh;
    broken.position[7].y = bad;
    EXPECT_THROW(encode(broken), GeometryError) << bad;
  }
  SemiRegularMesh twice = mesh;
  twice.base.push_back(twice.base[0]);
  EXPECT_THROW(encode(twice), GeometryError);
  SemiRegularMesh beyond = mesh;
  beyond.base[3][1] = 6;
  EXPECT_THROW(encode(beyond), GeometryError);
  SemiRegularMesh short_of = mesh;
  short_of.position.pop_back();
  EXPECT_THROW(encode(short_of), GeometryError);
}

/// Each wavelet says what it needs: what it says is enough, a byte less is not.
TEST(Archive, TakesItsMemoryFromTheBudget) {
  const SemiRegularMesh mesh = rough_mesh(test::base_of(test::octahedron()), 5, 0.05, 2);
  std::uint64_t needed_by_butterfly = 0;
  for (const Wavelet wavelet : {Wavelet::kLiftedButterfly, Wavelet::kLoop}) {
    const store::Bytes bytes = encode(mesh, {.wavelet = wavelet});
    const auto least_memory = [](const auto& work) {
      std::uint64_t low = 0;
      std::uint64_t high = kCodecMemory;
      while (high - low > 1) {
        const std::uint64_t middle = (low + high) / 2;
        MemoryBudget budget(middle);
        try {
          work(budget);
          high = middle;
        } catch (const BudgetError&) {
          low = middle;
        }
        EXPECT_EQ(budget.available(), budget.total());
      }
      return high;
    };
    const std::uint64_t encoding = least_memory([&](MemoryBudget& budget) {
      static_cast<void>(encode_mesh(mesh, {.wavelet = wavelet}, budget));
    });
    const std::uint64_t decoding = least_memory(
        [&](MemoryBudget& budget) { Archive(bytes, "archive").decode(bytes.size(), 5, budget); });
    EXPECT_GT(encoding, 100 * mesh.position.size());
    EXPECT_GT(decoding, 24 * mesh.position.size());
    // Loop's smoothing needs room of its own.
    if (wavelet == Wavelet::kLoop) {
      EXPECT_GT(encoding, needed_by_butterfly);
    }
    needed_by_butterfly = encoding;
  }
}

/// Nearer to the mesh with every byte, but for what rounding to middles may do.
TEST(Archive, IsTheBetterTheLonger) {
  const SemiRegularMesh mesh = in_order(rough_mesh(test::base_of(test::icosphere(1)), 4, 0.02, 11));
  for (const Wavelet wavelet : kWavelets) {
    const store::Bytes bytes = encode(mesh, {.wavelet = wavelet});
    const Archive archive(bytes, "archive");
    constexpr int kPrefixes = 60;
    const double least = double(archive.least_bytes());
    double best = 0;
    for (int i = 0; i <= kPrefixes; ++i) {
      const auto size =
          static_cast<std::uint64_t>(least * std::pow(double(bytes.size()) / least, i / 60.0));
      const SemiRegularMesh decoded = decode(bytes, size);
      double sum = 0;
      for (std::size_t v = 0; v < mesh.position.size(); ++v) {
        sum += norm2(decoded.position[v] - mesh.position[v]);
      }
      const double psnr = -10 * std::log10(sum / double(mesh.position.size()) /
                                           std::pow(test::diagonal_of(mesh), 2));
      EXPECT_GT(psnr, best - 0.05) << size << " bytes";
      best = std::max(best, psnr);
    }
    EXPECT_GT(best, 60);
  }
}

}  // namespace
}  // namespace remaps::codec
