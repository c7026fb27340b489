#include "remaps/pipeline/surface_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/formats/file_extension.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/image/image_encoding.h"
#include "remaps/measure/surface_pieces.h"
#include "remaps/pipeline/query_run.h"
#include "remaps/pipeline/sphere_files.h"
#include "remaps/pipeline/tile_surface.h"
#include "remaps/resample/attribute_sampler.h"
#include "remaps/resample/resampler.h"
#include "remaps/sphere/octahedral_unfolding.h"
#include "remaps/store/file.h"
#include "remaps/store/row_spool.h"

namespace remaps::pipeline {
namespace {

using image::Image;
using sphere::OctahedralGrid;

constexpr std::uint64_t kBytesPerPixel = 64;
constexpr std::uint32_t kMostPixels = 16'385;  // a side
constexpr std::uint32_t kMostSamples = 64;     // along a side of a pixel
constexpr std::uint64_t kLeastMeasuring = 8u << 20;

bool is_image(const std::string& extension) {
  return extension == ".exr" || extension == ".npy" || extension == ".png";
}

void check(const SurfaceImageOptions& o) {
  if (!is_writable_image(o.output, o.kind)) {
    throw InputError(fmt::format(
        "{}: expected an image, .exr, .png or .npy{}", o.output.string(),
        o.kind == ImageKind::geometry ? fmt::format(", or a mesh, {}", kWritableMeshes) : ""));
  }
  if (o.size < 3 || o.size > kMostPixels) {
    throw InputError(
        fmt::format("an image of {} pixels a side: from 3 to {} can be made", o.size, kMostPixels));
  }
  if (o.kind == ImageKind::geometry && o.size % 2 == 0) {
    throw InputError(fmt::format(
        "a geometry image has an odd size, so that its sides fold at a pixel: {} or {}, not {}",
        o.size - 1, o.size + 1, o.size));
  }
  if (o.supersampling < 1 || o.supersampling > kMostSamples) {
    throw InputError(fmt::format("--supersampling is from 1 to {}", kMostSamples));
  }
}

Vec3 face_normal(const Tile& tile, LocalIndex face) {
  const auto& t = tile.triangle[face];
  const Vec3 a = widen(tile.position[t[0]]);
  const Vec3 n = cross(widen(tile.position[t[1]]) - a, widen(tile.position[t[2]]) - a);
  const double length = norm(n);
  return length > 0 ? 1 / length * n : Vec3{};
}

/// Looks up points of the sphere on the input.
class ImageMaker {
 public:
  ImageMaker(const SurfaceImageOptions& options, Progress& progress)
      : options_(options),
        run_(options.query),
        sphere_(run_.bundle, run_.budget),
        progress_(progress),
        pixels_(std::uint64_t{options.size} * options.size),
        memory_(run_.budget.reserve(kBytesPerPixel * pixels_,
                                    fmt::format("an image of {0} x {0}", options.size))) {
    if (options.component >= sphere_.map().components()) {
      throw InputError(
          fmt::format("there is no sphere of component {}; there {} {}", options.component,
                      sphere_.map().components() == 1 ? "is" : "are", sphere_.map().components()));
    }
  }

  SurfaceImageSummary run() {
    summary_.size = options_.size;
    if (options_.kind == ImageKind::geometry) {
      make_geometry();
    } else if (options_.kind == ImageKind::normal) {
      make_normals();
    } else {
      make_colours();
    }
    return summary_;
  }

 private:
  using Take = std::function<void(const Tile&, const map::TaggedPoint&)>;

  /// @param points  calls its argument with each tag and direction; neighbours one after the other
  void look_up(
      const std::function<void(const std::function<void(std::uint64_t, const Vec3&)>&)>& points,
      const Take& take) {
    resample::ResampleOptions resample;
    resample.carry.threads = run_.threads;
    resample.carry.map_buffer = run_.plan.map_buffer;
    resample.carry.progress = &progress_;
    resample.buffer_bytes = std::min(run_.plan.bucket_bytes, run_.budget.available() / 4);
    resample.temp_dir = run_.temp.path();
    progress_.begin("points to the input");
    const auto produce = [&](const std::function<void(const map::TaggedPoint&)>& add) {
      LocalIndex near = sphere_.map().first_face(options_.component);
      points([&](std::uint64_t tag, const Vec3& direction) {
        const sphere::FaceWeights at = sphere_.map().locate(direction, near);
        near = at.face;
        add({tag, {at.face, at.u, at.v}});
        ++summary_.samples;
      });
    };
    resample::pull_back(
        run_.bundle.files(), produce, resample, run_.budget,
        [&](std::uint32_t, const Tile& tile, std::span<const map::TaggedPoint> batch) {
          for (const map::TaggedPoint& point : batch) take(tile, point);
        });
  }

  void make_geometry() {
    const OctahedralGrid grid(options_.size);
    std::vector<Vec3> position(pixels_);
    const auto for_pixels = [&](auto&& visit) {
      for (std::uint32_t row = 0; row < options_.size; ++row) {
        for (std::uint32_t column = 0; column < options_.size; ++column) {
          visit(row, column, std::uint64_t{row} * options_.size + column);
        }
      }
    };
    look_up(
        [&](const auto& add) {
          for_pixels([&](std::uint32_t row, std::uint32_t column, std::uint64_t pixel) {
            if (grid.first_same(row, column) == pixel) add(pixel, grid.direction(row, column));
          });
        },
        [&](const Tile& tile, const map::TaggedPoint& point) {
          position[point.tag] = resample::position_on_tile(tile, point.at);
        });
    for_pixels([&](std::uint32_t row, std::uint32_t column, std::uint64_t pixel) {
      position[pixel] = position[grid.first_same(row, column)];
    });
    if (options_.measure) measure(grid, position);
    progress_.check();
    const Vec3 origin = run_.bundle.manifest().origin;
    for (Vec3& p : position) p = origin + p;
    if (is_image(lower_extension(options_.output))) {
      write_image(position);
    } else {
      write_mesh(grid, position);
    }
  }

  std::uint64_t samples_per_pixel() const {
    return std::uint64_t{options_.supersampling} * options_.supersampling;
  }

  /// Looks up all samples of all pixels: those of pixel p have the numbers from
  /// p * samples_per_pixel() on.
  void look_up_samples(const Take& take) {
    const std::uint32_t n = options_.size, k = options_.supersampling;
    const double samples = double(n) * k;
    look_up(
        [&](const auto& add) {
          std::uint64_t number = 0;
          for (std::uint32_t row = 0; row < n; ++row) {
            for (std::uint32_t column = 0; column < n; ++column) {
              for (std::uint32_t s = 0; s < k * k; ++s) {
                const double x = (double(column) * k + s % k + 0.5) / samples;
                const double y = (double(row) * k + s / k + 0.5) / samples;
                add(number++, sphere::octahedral_direction(2 * x - 1, 1 - 2 * y));
              }
            }
          }
        },
        take);
  }

  void make_normals() {
    std::vector<Vec3> sum(pixels_);
    const std::uint64_t each = samples_per_pixel();
    look_up_samples([&](const Tile& tile, const map::TaggedPoint& point) {
      Vec3& pixel = sum[point.tag / each];
      pixel = pixel + face_normal(tile, point.at.face);
    });
    for (Vec3& v : sum) {
      const double length = norm(v);
      v = length > 0 ? 1 / length * v : Vec3{0, 0, 1};
    }
    write_image(sum);
  }

  /// The colours that vertices of the input have.
  AttributeSpec colours_of_input() const {
    AttributeFile* const attributes = run_.bundle.attributes();
    if (attributes != nullptr) {
      for (const AttributeSpec& spec : attributes->layout().specs) {
        if (spec.kind == AttributeKind::colour && spec.per == AttributePer::vertex &&
            spec.components.size() >= 3) {
          return spec;
        }
      }
    }
    throw InputError(options_.query.bundle.string() +
                     ": has no colours of vertices; remaps info lists what it has");
  }

  void make_colours() {
    const AttributeSpec spec = colours_of_input();
    const std::uint64_t each = samples_per_pixel();
    resample::VertexAttributeSampler sampler(*run_.bundle.attributes(), std::span(&spec, 1),
                                             pixels_ * each, run_.temp.path(),
                                             run_.budget.available() / 8, run_.budget);
    look_up_samples([&](const Tile& tile, const map::TaggedPoint& point) {
      sampler.add(tile, std::span(&point, 1));
    });
    store::RowSpool rows(run_.temp.path() / "colours", row_bytes(spec));
    progress_.begin("colours");
    sampler.finish(rows, run_.budget.available() / 4, &progress_);
    std::vector<Vec3> mean(pixels_);
    std::vector<std::byte> bytes(static_cast<std::size_t>(each) * rows.row_bytes());
    std::vector<double> values(spec.components.size());
    for (std::uint64_t pixel = 0; pixel < pixels_; ++pixel) {
      rows.read(pixel * each, bytes);
      Vec3 sum;
      for (std::size_t s = 0; s < each; ++s) {
        unpack_row(std::span(&spec, 1),
                   std::span(bytes).subspan(s * rows.row_bytes(), rows.row_bytes()), values);
        const auto full = [&](std::size_t c) { return full_colour(spec.components[c].type); };
        sum = sum + Vec3{values[0] / full(0), values[1] / full(1), values[2] / full(2)};
      }
      mean[pixel] = 1.0 / static_cast<double>(each) * sum;
    }
    write_image(mean);
  }

  /// Two triangles a cell, counter-clockwise seen from outside, along the shorter diagonal.
  template <class Visit>
  void for_triangles(const OctahedralGrid& grid, const std::vector<Vec3>& position,
                     Visit&& visit) const {
    for (std::uint32_t row = 0; row + 1 < grid.size(); ++row) {
      for (std::uint32_t column = 0; column + 1 < grid.size(); ++column) {
        const std::uint64_t a = grid.first_same(row + 1, column),
                            b = grid.first_same(row + 1, column + 1),
                            c = grid.first_same(row, column + 1), d = grid.first_same(row, column);
        const bool along_ac = norm2(position[a] - position[c]) <= norm2(position[b] - position[d]);
        visit(along_ac ? Triangle{a, b, c} : Triangle{a, b, d});
        visit(along_ac ? Triangle{a, c, d} : Triangle{b, c, d});
      }
    }
  }

  void measure(const OctahedralGrid& grid, const std::vector<Vec3>& position) {
    progress_.begin("measure");
    SurfaceErrorOptions options;
    options.samples = options_.samples;
    options.threads = run_.threads;
    options.memory_bytes = std::max(run_.budget.available() / 2, kLeastMeasuring);
    options.progress = &progress_;
    const TriangleSource mesh = [&](TriangleSink sink) {
      constexpr std::size_t kChunk = 4096;
      std::vector<TrianglePositions> chunk;
      for_triangles(grid, position, [&](const Triangle& t) {
        chunk.push_back({position[t[0]], position[t[1]], position[t[2]]});
        if (chunk.size() < kChunk) return;
        sink(chunk);
        chunk.clear();
      });
      if (!chunk.empty()) sink(chunk);
    };
    summary_.error = measure_surface_error(TilePieces(run_.bundle.tiles()),
                                           StreamedPieces(mesh, options.memory_bytes), options);
  }

  void write_image(const std::vector<Vec3>& value) const {
    Image image;
    image.width = image.height = options_.size;
    if (options_.kind == ImageKind::colour) image.channels = "RGB";
    image.value.reserve(3 * value.size());
    Box3 box;
    for (const Vec3& v : value) {
      const Vec3f f = to_float(v);
      image.value.insert(image.value.end(), {f.x, f.y, f.z});
      box.add(widen(f));
    }
    const std::string extension = lower_extension(options_.output);
    std::string bytes;
    if (extension == ".png") {
      image::IntegerRange range{options_.bits, {-1, -1, -1}, 2};
      if (options_.kind == ImageKind::colour) range = {options_.bits, {0, 0, 0}, 1};
      if (options_.kind == ImageKind::geometry) {
        const Vec3 extent = box.high - box.low;
        const Vec3f low = to_float(box.low);
        range = {options_.bits,
                 {low.x, low.y, low.z},
                 static_cast<float>(std::max({extent.x, extent.y, extent.z}))};
      }
      bytes = encode_png(image, range);
    } else {
      bytes = extension == ".exr" ? encode_exr(image) : encode_npy(image);
    }
    store::write_file_atomically(options_.output, bytes);
  }

  void write_mesh(const OctahedralGrid& grid, const std::vector<Vec3>& position) const {
    std::vector<std::uint64_t> number(position.size());
    std::vector<Vec3> vertex;
    for (std::uint32_t row = 0; row < grid.size(); ++row) {
      for (std::uint32_t column = 0; column < grid.size(); ++column) {
        const std::uint64_t pixel = std::uint64_t{row} * grid.size() + column;
        const std::uint64_t first = grid.first_same(row, column);
        number[pixel] = first == pixel ? vertex.size() : number[first];
        if (first == pixel) vertex.push_back(position[pixel]);
      }
    }
    const std::uint64_t cells = std::uint64_t{grid.size() - 1} * (grid.size() - 1);
    const auto writer = open_mesh_writer(options_.output, vertex.size(), 2 * cells);
    writer->write_positions(vertex);
    std::vector<Triangle> triangles;
    for_triangles(grid, position, [&](const Triangle& t) {
      triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    });
    writer->write_triangles(triangles);
    writer->close();
  }

  const SurfaceImageOptions& options_;
  QueryRun run_;
  SphereFiles sphere_;
  Progress& progress_;
  std::uint64_t pixels_;
  Reservation memory_;
  SurfaceImageSummary summary_;
};

}  // namespace

bool is_writable_image(const std::filesystem::path& path, ImageKind kind) {
  return is_image(lower_extension(path)) || (kind == ImageKind::geometry && is_writable_mesh(path));
}

SurfaceImageSummary make_surface_image(const SurfaceImageOptions& options, Progress& progress) {
  check(options);
  return ImageMaker(options, progress).run();
}

}  // namespace remaps::pipeline
