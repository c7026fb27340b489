#include "remaps/measure/surface_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "measure/test_surfaces.h"
#include "remaps/base/errors.h"

namespace remaps {
namespace {

using test::bumpy_sphere;
using test::Soup;
using test::source_of;
using test::square;

#if defined(REMAPS_FORCE_SPILL)
constexpr std::uint64_t kMemory = 1 << 20;
#else
constexpr std::uint64_t kMemory = 64 << 20;
#endif

SurfaceError measure(const Soup& original, const Soup& remesh, std::uint64_t samples = 20'000) {
  return measure_surface_error(source_of(original), source_of(remesh),
                               {.samples = samples, .memory_bytes = kMemory});
}

void expect_equal(const SurfaceError& a, const SurfaceError& b, double tolerance) {
  EXPECT_EQ(a.diagonal, b.diagonal);
  EXPECT_EQ(a.samples_forward, b.samples_forward);
  EXPECT_EQ(a.samples_backward, b.samples_backward);
  EXPECT_NEAR(a.l2_forward, b.l2_forward, tolerance);
  EXPECT_NEAR(a.mean_forward, b.mean_forward, tolerance);
  EXPECT_NEAR(a.max_forward, b.max_forward, tolerance);
  EXPECT_NEAR(a.l2_backward, b.l2_backward, tolerance);
  EXPECT_NEAR(a.mean_backward, b.mean_backward, tolerance);
  EXPECT_NEAR(a.max_backward, b.max_backward, tolerance);
}

TEST(SurfaceError, OfParallelSquaresIsTheirDistance) {
  const SurfaceError e = measure(square(0, 0), square(0, 0.25));
  EXPECT_DOUBLE_EQ(e.diagonal, std::sqrt(2.0));
  const double d = 0.25 / std::sqrt(2.0);
  for (const double error : {e.l2_forward, e.mean_forward, e.max_forward, e.l2_backward,
                             e.mean_backward, e.max_backward, e.l2()}) {
    EXPECT_NEAR(error, d, 1e-14);
  }
  EXPECT_EQ(e.samples_forward, 20'000u);
  EXPECT_EQ(e.samples_backward, 20'000u);
}

TEST(SurfaceError, OfASquareShiftedInItsPlaneIsTheUncoveredStrip) {
  const double s = 0.3;
  const SurfaceError e = measure(square(0, 0), square(s, 0), 200'000);
  const double diagonal = std::sqrt(2.0);
  EXPECT_NEAR(e.l2_forward * diagonal, std::sqrt(s * s * s / 3), 2e-4);
  EXPECT_NEAR(e.mean_forward * diagonal, s * s / 2, 1e-4);
  EXPECT_NEAR(e.max_forward * diagonal, s, 1e-14);  // at a corner
  EXPECT_NEAR(e.l2_backward * diagonal, std::sqrt(s * s * s / 3), 2e-4);
  EXPECT_NEAR(e.max_backward * diagonal, s, 1e-14);
}

TEST(SurfaceError, OfAPyramidIsThatOfALinearHeight) {
  const double h = 0.1;
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{1, 1, 0}, d{0, 1, 0}, apex{0.5, 0.5, h};
  const Soup pyramid{{a, b, apex}, {b, c, apex}, {c, d, apex}, {d, a, apex}};
  const SurfaceError e = measure(square(0, 0), pyramid, 100'000);
  EXPECT_NEAR(e.l2_backward * e.diagonal, h / std::sqrt(6.0), 1e-4);
  EXPECT_NEAR(e.mean_backward * e.diagonal, h / 3, 1e-4);
  EXPECT_NEAR(e.max_backward * e.diagonal, h, 1e-14);
  EXPECT_EQ(e.l2(), std::max(e.l2_forward, e.l2_backward));
}

TEST(SurfaceError, OfASurfaceAndItselfIsRounding) {
  Soup soup = bumpy_sphere(50, 0.01, 1);
  for (TrianglePositions& triangle : soup) {
    for (Vec3& corner : triangle) corner = corner + Vec3{3, 5, -7};
  }
  const SurfaceError e = measure(soup, soup, 50'000);
  EXPECT_LT(e.max_forward, 1e-14);
  EXPECT_LT(e.max_backward, 1e-14);
}

TEST(SurfaceError, SamplesInProportionToArea) {
  // One triangle of height 1 with nine times the area of the one in the plane.
  const Soup soup{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {{{0, 0, 1}, {3, 0, 1}, {0, 3, 1}}}};
  const Soup plane{{{{-9, -9, 0}, {30, -9, 0}, {-9, 30, 0}}}};
  const SurfaceError e = measure(soup, plane, 100'000);
  EXPECT_NEAR(e.mean_forward * e.diagonal, 0.9, 1e-5);
}

TEST(SurfaceError, DoesNotDependOnMemory) {
  Soup fine = bumpy_sphere(120, 0.001, 1), coarse = bumpy_sphere(60, 0, 2);
  const auto with = [&](std::uint64_t bytes) {
    return measure_surface_error(source_of(fine), source_of(coarse),
                                 {.samples = 30'000, .memory_bytes = bytes});
  };
  expect_equal(with(1 << 20), with(1 << 28), 1e-12);

  std::mt19937_64 random(1);  // parts that all spread over the whole
  std::shuffle(fine.begin(), fine.end(), random);
  std::shuffle(coarse.begin(), coarse.end(), random);
  expect_equal(with(1 << 20), with(1 << 28), 1e-12);
}

TEST(SurfaceError, DoesNotDependOnWhichSurfaceIsLarger) {
  const Soup fine = bumpy_sphere(60, 0.001, 1), coarse = bumpy_sphere(30, 0, 2);
  const SurfaceError a = measure(fine, coarse), b = measure(coarse, fine);
  EXPECT_NEAR(a.l2_forward * a.diagonal, b.l2_backward * b.diagonal, 1e-15);
  EXPECT_NEAR(a.max_backward * a.diagonal, b.max_forward * b.diagonal, 1e-15);
}

TEST(SurfaceError, DoesNotDependOnTheChunksOfTheStream) {
  const Soup fine = bumpy_sphere(40, 0.001, 1), coarse = bumpy_sphere(20, 0, 2);
  const auto in_chunks = [&](std::size_t n) {
    return measure_surface_error(source_of(fine, n), source_of(coarse, n),
                                 {.samples = 10'000, .memory_bytes = kMemory});
  };
  expect_equal(in_chunks(1), in_chunks(100'000), 0);
}

TEST(SurfaceError, IsTheSameForAnyNumberOfThreads) {
  const Soup fine = bumpy_sphere(100, 0.001, 1), coarse = bumpy_sphere(40, 0, 2);
  for (const std::uint64_t bytes : {std::uint64_t{1} << 20, std::uint64_t{1} << 28}) {
    const auto with = [&](unsigned threads) {
      return measure_surface_error(source_of(fine), source_of(coarse),
                                   {.samples = 50'000, .threads = threads, .memory_bytes = bytes});
    };
    expect_equal(with(1), with(2), 0);
    expect_equal(with(1), with(5), 0);
  }
}

TEST(SurfaceError, IgnoresTrianglesWithoutArea) {
  const Soup clean = bumpy_sphere(20, 0.01, 1), other = bumpy_sphere(14, 0.01, 2);
  Soup soup;
  for (const TrianglePositions& t : clean) {
    soup.push_back(t);
    soup.push_back({t[0], t[0], t[0]});
    soup.push_back({t[0], t[1], t[0]});
    soup.push_back({t[0], t[1], 0.5 * (t[0] + t[1])});
  }
  expect_equal(measure(soup, other), measure(clean, other), 1e-9);
}

TEST(SurfaceError, OfConcentricSpheresIsTheDifferenceOfTheirRadii) {
  const auto sphere = [](double radius) {
    Soup soup = bumpy_sphere(60, 0, 1);
    for (TrianglePositions& triangle : soup) {
      for (Vec3& corner : triangle) corner = (radius / norm(corner)) * corner;
    }
    return soup;
  };
  const SurfaceError e = measure(sphere(1), sphere(1.5), 5'000);
  for (const double error : {e.l2_forward, e.mean_forward, e.max_forward, e.l2_backward,
                             e.mean_backward, e.max_backward}) {
    EXPECT_NEAR(error * e.diagonal, 0.5, 0.003);  // facets are inside of their sphere
  }
}

TEST(SurfaceError, OfOneHugeTriangleAgainstManyIsTheirHeight) {
  // A plane that passes through the middle of a bumpy field of tiny triangles.
  Soup field;
  const auto height = [](int i, int j) { return ((i * 7 + j * 5) % 11 - 5) * 1e-3; };
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const auto at = [&](int x, int y) { return Vec3{0.01 * x, 0.01 * y, height(x, y)}; };
      field.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      field.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  const Soup plane{{{{-1, -1, 0}, {4, -1, 0}, {-1, 4, 0}}}};
  const SurfaceError e = measure(field, plane, 100'000);
  EXPECT_NEAR(e.max_forward * e.diagonal, 5e-3, 1e-15);  // at corners
  EXPECT_LT(e.mean_forward, e.l2_forward);
  EXPECT_LT(e.l2_forward * e.diagonal, 5e-3);
  // The plane's corner lies sqrt(9.25...) away from the field; most of it is outside.
  EXPECT_NEAR(e.max_backward * e.diagonal, std::sqrt(10.0), 1e-3);
  const SurfaceError swapped = measure(plane, field, 100'000);
  EXPECT_NEAR(swapped.l2_backward * swapped.diagonal, e.l2_forward * e.diagonal, 1e-15);
}

TEST(SurfaceError, OfSurfacesFarApartIsTheWayBetweenThem) {
  Soup far = bumpy_sphere(30, 0, 1), near = bumpy_sphere(50, 0, 2);
  for (TrianglePositions& triangle : far) {
    for (Vec3& corner : triangle) corner = corner + Vec3{1000, 0, 0};
  }
  const SurfaceError e = measure(far, near, 2'000);
  for (const double mean : {e.mean_forward * e.diagonal, e.mean_backward * e.diagonal}) {
    EXPECT_NEAR(mean, 999, 0.3);
  }
}

TEST(SurfaceError, RefusesWhatIsNoSurface) {
  const Soup good = square(0, 0), empty;
  const Soup flat{{{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}};
  const Soup wild{{{{0, 0, 0}, {1, 0, 0}, {0, std::numeric_limits<double>::quiet_NaN(), 0}}}};
  for (const Soup& bad : {empty, flat, wild}) {
    EXPECT_THROW(measure(bad, good), GeometryError);
    EXPECT_THROW(measure(good, bad), GeometryError);
  }
}

TEST(SurfaceError, RefusesAnImpossibleBudget) {
  const Soup soup = square(0, 0);
  EXPECT_THROW(measure_surface_error(source_of(soup), source_of(soup), {.memory_bytes = 1000}),
               BudgetError);
}

TEST(SurfaceError, StopsWhenAsked) {
  const Soup soup = bumpy_sphere(20, 0.01, 1);
  double last = -1;
  Progress counting([&](std::string_view, double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  SurfaceErrorOptions options{.samples = 10'000, .threads = 2, .progress = &counting};
  measure_surface_error(source_of(soup), source_of(soup), options);
  EXPECT_DOUBLE_EQ(last, 1);

  Progress stopped;
  stopped.cancel();
  options.progress = &stopped;
  EXPECT_THROW(measure_surface_error(source_of(soup), source_of(soup), options), Cancelled);
}

}  // namespace
}  // namespace remaps
