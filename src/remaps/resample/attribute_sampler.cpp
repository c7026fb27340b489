#include "remaps/resample/attribute_sampler.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "remaps/resample/attribute_mixer.h"
#include "remaps/resample/corner_values.h"

namespace remaps::resample {
namespace {

using map::TaggedPoint;

/// Sums up rows by weights, a range of points at a time.
class MixGather final : public store::RowJoin::Gather {
 public:
  MixGather(AttributeMixer& mixer, store::RowSpool& rows) : mixer_(mixer), rows_(rows) {}

  static std::size_t bytes_each(const AttributeMixer& mixer) {
    return (mixer.channels() + 1) * sizeof(double) + mixer.row_bytes();
  }

  void begin(std::uint64_t count) override {
    sum_.assign(static_cast<std::size_t>(count) * mixer_.channels(), 0);
    heaviest_.assign(static_cast<std::size_t>(count), 0);
  }
  void take(std::size_t number, store::ByteSpan payload, store::ByteSpan row) override {
    double weight = 0;
    std::memcpy(&weight, payload.data(), sizeof weight);
    mixer_.add(row, weight, sum_of(number), heaviest_[number]);
  }
  void end() override {
    out_.resize(heaviest_.size() * mixer_.row_bytes());
    for (std::size_t i = 0; i < heaviest_.size(); ++i) {
      mixer_.finish(sum_of(i), std::span(out_).subspan(i * mixer_.row_bytes(), mixer_.row_bytes()));
    }
    rows_.append(out_);
  }

 private:
  std::span<double> sum_of(std::size_t i) {
    return std::span(sum_).subspan(i * mixer_.channels(), mixer_.channels());
  }

  AttributeMixer& mixer_;
  store::RowSpool& rows_;
  std::vector<double> sum_;
  std::vector<double> heaviest_;
  store::Bytes out_;
};

/// Takes rows as they are.
class CopyGather final : public store::RowJoin::Gather {
 public:
  explicit CopyGather(store::RowSpool& rows) : rows_(rows) {}

  void begin(std::uint64_t count) override {
    out_.assign(static_cast<std::size_t>(count) * rows_.row_bytes(), std::byte{});
  }
  void take(std::size_t number, store::ByteSpan, store::ByteSpan row) override {
    std::copy(row.begin(), row.end(),
              out_.begin() + static_cast<std::ptrdiff_t>(number * rows_.row_bytes()));
  }
  void end() override { rows_.append(out_); }

 private:
  store::RowSpool& rows_;
  store::Bytes out_;
};

/// Works out the corners of each face from its four points.
class CornerGather final : public store::RowJoin::Gather {
 public:
  CornerGather(std::vector<AttributeSpec> specs, store::RowSpool& rows)
      : values_(std::move(specs)), rows_(rows) {}

  void begin(std::uint64_t count) override {
    found_.assign(static_cast<std::size_t>(count) * 4, {});
    kept_.resize(static_cast<std::size_t>(count) * 4 * 3 * values_.input_row_bytes());
  }
  void take(std::size_t number, store::ByteSpan payload, store::ByteSpan row) override {
    FaceSample sample;
    std::memcpy(&sample, payload.data(), sizeof sample);
    const std::size_t at = 4 * number + sample.slot;
    found_[at] = sample;
    found_[at].there = 1;
    std::copy(row.begin(), row.end(), kept_.begin() + static_cast<std::ptrdiff_t>(at * row.size()));
  }
  void end() override {
    const std::size_t row = 3 * values_.row_bytes(), kept = 12 * values_.input_row_bytes();
    out_.resize(found_.size() / 4 * row);
    for (std::size_t f = 0; f < found_.size() / 4; ++f) {
      values_.find(std::span(found_).subspan(4 * f, 4), std::span(kept_).subspan(f * kept, kept),
                   std::span(out_).subspan(f * row, row));
    }
    rows_.append(out_);
  }

 private:
  CornerValues values_;
  store::RowSpool& rows_;
  std::vector<FaceSample> found_;
  store::Bytes kept_, out_;
};

/// Sends the points of all faces: three near the corners, if wanted, and the centre.
void produce_face_points(const DyadicGrid& grid, bool corners,
                         const std::function<void(const TaggedPoint&)>& add) {
  const auto n = double(std::uint64_t{1} << grid.level());
  for (std::uint64_t f = 0; f < grid.faces(); ++f) {
    const auto corner = grid.corners(f);
    const auto point = [&](std::uint64_t slot, const std::array<double, 3>& weight) {
      double u = 0, v = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        u += weight[i] * corner[i][0];
        v += weight[i] * corner[i][1];
      }
      const auto face = static_cast<std::uint32_t>(f / grid.faces_per_base_face());
      add({4 * f + slot, {face, u / n, v / n}});
    };
    for (std::size_t i = 0; corners && i < 3; ++i) {
      std::array<double, 3> weight{kInwards, kInwards, kInwards};
      weight[i] = 1 - 2 * kInwards;
      point(i, weight);
    }
    point(kCentre, {1.0 / 3, 1.0 / 3, 1.0 / 3});
  }
}

FaceSample face_sample(const Tile& tile, const TaggedPoint& point, AttributeFile& attributes) {
  FaceSample sample;
  for (std::size_t i = 0; i < 3; ++i) {
    sample.vertex[i] = attributes.original(tile.vertex_id[tile.triangle[point.at.face][i]]);
  }
  sample.slot = static_cast<std::uint8_t>(point.tag % 4);
  sample.u = point.at.u;
  sample.v = point.at.v;
  if (sample.slot == kCentre) {
    for (std::size_t i = 0; i < 3; ++i) {
      sample.position[i] = tile.position[tile.triangle[point.at.face][i]];
    }
  } else {
    sample.position[0] = to_float(position_on_tile(tile, point.at));
  }
  return sample;
}

/// Asks for what the faces of a grid need.
class FaceRequests {
 public:
  FaceRequests(AttributeFile& attributes, std::span<const AttributeSpec> specs,
               const DyadicGrid& grid, const ResampleOptions& options, std::uint64_t buffer_bytes,
               MemoryBudget& budget)
      : attributes_(attributes),
        specs_(specs),
        face_columns_(attributes, AttributePer::face, specs),
        corner_columns_(attributes, AttributePer::corner, specs),
        points_(grid.faces() * (corner_columns_.row_bytes() > 0 ? 4 : 1)) {
    const std::size_t face = face_columns_.row_bytes(), corner = corner_columns_.row_bytes();
    if (face > 0) {
      faces_.emplace("face-attributes", options.temp_dir,
                     store::RowJoin::Shape{face_columns_.rows(), grid.faces(), face, 0, face},
                     buffer_bytes, budget);
    }
    if (corner > 0) {
      corners_.emplace(
          "corner-attributes", options.temp_dir,
          store::RowJoin::Shape{corner_columns_.rows(), grid.faces(), corner, sizeof(FaceSample),
                                4 * (sizeof(FaceSample) + corner) + corner},
          buffer_bytes, budget);
    }
  }

  bool corners() const { return corners_.has_value(); }

  void add(const Tile& tile, std::span<const TaggedPoint> points) {
    for (const TaggedPoint& point : points) {
      ++seen_;
      const FaceId face = tile.face_id[point.at.face];
      if (face >= attributes_.layout().faces) continue;  // made by repair: it has nothing
      if (faces_ && point.tag % 4 == kCentre) faces_->ask(face, point.tag / 4, {});
      if (!corners_) continue;
      const FaceSample sample = face_sample(tile, point, attributes_);
      corners_->ask(face, point.tag / 4, std::as_bytes(std::span(&sample, 1)));
    }
  }

  void finish(const ResampleOptions& options, store::RowSpool* face_rows,
              store::RowSpool* corner_rows) {
    if (seen_ != points_) throw CorruptionError("points of faces were lost on the way");
    const auto run = [&](store::RowJoin& join, AttributeColumns& columns,
                         store::RowJoin::Gather& gather) {
      join.run([&](std::uint64_t first, std::span<std::byte> out) { columns.read(first, out); },
               gather, options.buffer_bytes,
               [&](double fraction) {
                 if (options.carry.progress != nullptr) options.carry.progress->advance(fraction);
               });
    };
    if (faces_) {
      const ProgressPart part(options.carry.progress, 0, 0.3);
      CopyGather gather(*face_rows);
      run(*faces_, face_columns_, gather);
    }
    if (corners_) {
      const ProgressPart part(options.carry.progress, 0.3, 1);
      CornerGather gather(attributes_per(specs_, AttributePer::corner), *corner_rows);
      run(*corners_, corner_columns_, gather);
    }
  }

 private:
  AttributeFile& attributes_;
  std::span<const AttributeSpec> specs_;
  AttributeColumns face_columns_, corner_columns_;
  std::uint64_t points_, seen_ = 0;
  std::optional<store::RowJoin> faces_, corners_;
};

}  // namespace

VertexAttributeSampler::VertexAttributeSampler(AttributeFile& attributes,
                                               std::span<const AttributeSpec> specs,
                                               std::uint64_t points,
                                               const std::filesystem::path& temp_dir,
                                               std::uint64_t buffer_bytes, MemoryBudget& budget)
    : attributes_(attributes),
      points_(points),
      columns_(attributes, AttributePer::vertex, specs),
      mixer_(attributes_per(specs, AttributePer::vertex)),
      join_("vertex-attributes", temp_dir,
            {columns_.rows(), points, columns_.row_bytes(), sizeof(double),
             MixGather::bytes_each(mixer_)},
            buffer_bytes, budget) {}

void VertexAttributeSampler::add(const Tile& tile, std::span<const TaggedPoint> points) {
  for (const TaggedPoint& point : points) {
    const auto& t = tile.triangle[point.at.face];
    const std::array<double, 3> weight = {1 - point.at.u - point.at.v, point.at.u, point.at.v};
    std::array<std::pair<VertexId, double>, 3> corner;
    double known = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      corner[i] = {attributes_.original(tile.vertex_id[t[i]]), weight[i]};
      if (corner[i].first == kNoVertex) known -= std::exchange(corner[i].second, 0);
    }
    // In the order of rows: so sums do not depend on memory.
    std::sort(corner.begin(), corner.end());
    for (const auto& [vertex, part] : corner) {
      const double share = known == 1 ? part : part / known;
      if (part > 0) join_.ask(vertex, point.tag, std::as_bytes(std::span(&share, 1)));
    }
  }
  seen_ += points.size();
}

void VertexAttributeSampler::finish(store::RowSpool& rows, std::uint64_t buffer_bytes,
                                    Progress* progress) {
  if (seen_ != points_) throw CorruptionError("points of vertices were lost on the way");
  MixGather gather(mixer_, rows);
  join_.run([this](std::uint64_t first, std::span<std::byte> out) { columns_.read(first, out); },
            gather, buffer_bytes,
            [&](double fraction) {
              if (progress != nullptr) progress->advance(fraction);
            });
}

void sample_face_attributes(const MapFiles& files, AttributeFile& attributes,
                            std::span<const AttributeSpec> specs, const DyadicGrid& grid,
                            const ResampleOptions& options, MemoryBudget& budget,
                            store::RowSpool* face_rows, store::RowSpool* corner_rows) {
  if (4 * grid.faces() > store::kMaxId40) {
    throw BudgetError(std::to_string(grid.faces()) +
                      " faces are too many for attributes of faces: leave these out with "
                      "--attributes, or use a lower level");
  }
  FaceRequests requests(attributes, specs, grid, options,
                        std::min(options.buffer_bytes, budget.available() / 2) / 8, budget);
  {
    const ProgressPart part(options.carry.progress, 0, 0.8);
    pull_back(
        files, [&](const auto& add) { produce_face_points(grid, requests.corners(), add); },
        options, budget,
        [&](std::uint32_t, const Tile& tile, std::span<const TaggedPoint> points) {
          requests.add(tile, points);
        });
  }
  const ProgressPart part(options.carry.progress, 0.8, 1);
  requests.finish(options, face_rows, corner_rows);
}

}  // namespace remaps::resample
