#include "remaps/resample/corner_values.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace remaps::resample {
namespace {

/// A corner's texture coordinates belong to another chart when they lie farther from those that the
/// centre's input face foretells than this many times the extent that it foretells for the face.
constexpr double kSeam = 2;

/// Weights of a point's projection to the plane of a triangle; not finite if that has no area.
std::array<double, 3> weights_of(const std::array<Vec3f, 3>& triangle, const Vec3& p) {
  const Vec3 a = widen(triangle[0]), b = widen(triangle[1]), c = widen(triangle[2]);
  const Vec3 normal = cross(b - a, c - a);
  const double area = norm2(normal);
  const double v = dot(cross(p - a, c - a), normal) / area;
  const double w = dot(cross(b - a, p - a), normal) / area;
  return {1 - v - w, v, w};
}

struct Uv {
  double u = 0, v = 0;
};
double distance(const Uv& a, const Uv& b) {
  return std::hypot(a.u - b.u, a.v - b.v);
}

}  // namespace

CornerValues::CornerValues(std::vector<AttributeSpec> specs) : mixer_(std::move(specs)) {
  std::size_t channel = 0;
  for (const AttributeSpec& spec : mixer_.specs()) {
    if (spec.kind == AttributeKind::uv && spec.components.size() == 2) uv_.push_back(channel);
    channel += spec.components.size();
  }
  for (auto& values : value_) values.resize(channel);
  for (auto& values : centre_) values.resize(channel);
}

/// The row of a vertex of a face. One that the face does not name, which only repair could have
/// made, has the row at its place.
std::span<const std::byte> CornerValues::row_of(VertexId vertex, std::size_t corner,
                                                std::span<const std::byte> rows) const {
  const std::size_t width = input_row_bytes();
  for (std::size_t i = 0; i < 3; ++i) {
    VertexId found = 0;
    std::memcpy(&found, rows.data() + i * width, sizeof found);
    if (found == vertex) corner = i;
  }
  return rows.subspan(corner * width + sizeof(VertexId), row_bytes());
}

void CornerValues::interpolate(const FaceSample& sample, std::span<const std::byte> rows,
                               std::span<double> values) {
  const std::array<double, 3> weight = {1 - sample.u - sample.v, sample.u, sample.v};
  double heaviest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (weight[i] > 0) {
      mixer_.add(row_of(sample.vertex[i], i, rows), weight[i], values, heaviest);
    }
  }
}

void CornerValues::mend_seams(std::span<const FaceSample> sample,
                              std::span<const std::byte> centre_rows) {
  for (std::size_t i = 0; i < 3; ++i) {
    unpack_row(mixer_.specs(), row_of(sample[kCentre].vertex[i], i, centre_rows), centre_[i]);
  }
  for (const std::size_t c : uv_) {
    std::array<Uv, 3> foretold;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto weight = weights_of(sample[kCentre].position, widen(sample[i].position[0]));
      for (std::size_t k = 0; k < 3; ++k) {
        foretold[i].u += weight[k] * centre_[k][c];
        foretold[i].v += weight[k] * centre_[k][c + 1];
      }
    }
    const double extent =
        std::max({distance(foretold[0], foretold[1]), distance(foretold[1], foretold[2]),
                  distance(foretold[2], foretold[0])});
    if (!(extent > 0) || !std::isfinite(extent)) continue;  // the input face foretells nothing
    for (std::size_t i = 0; i < 3; ++i) {
      const Uv own{value_[i][c], value_[i][c + 1]};
      if (distance(own, foretold[i]) <= kSeam * extent) continue;
      value_[i][c] = foretold[i].u;
      value_[i][c + 1] = foretold[i].v;
    }
  }
}

void CornerValues::find(std::span<const FaceSample> sample, std::span<const std::byte> rows,
                        std::span<std::byte> out) {
  const std::size_t face = 3 * input_row_bytes();
  for (std::size_t i = 0; i < 3; ++i) {
    std::fill(value_[i].begin(), value_[i].end(), 0.0);
    if (sample[i].there != 0) interpolate(sample[i], rows.subspan(i * face, face), value_[i]);
  }
  const bool all =
      std::all_of(sample.begin(), sample.end(), [](const FaceSample& s) { return s.there != 0; });
  if (all) mend_seams(sample, rows.subspan(kCentre * face, face));
  // A corner in a hole that was filled has nothing of its own: the texture of the rim goes on.
  for (std::size_t i = 0; i < 3; ++i) {
    if (sample[i].there != 0) continue;
    const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
    if (sample[next].there != 0) {
      value_[i] = value_[next];
    } else if (sample[last].there != 0) {
      value_[i] = value_[last];
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    mixer_.finish(value_[i], out.subspan(i * row_bytes(), row_bytes()));
  }
}

}  // namespace remaps::resample
