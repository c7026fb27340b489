#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "fuzz_targets.h"
#include "remaps/base/errors.h"
#include "remaps/formats/mesh_reader.h"

namespace remaps::fuzz {
namespace {

/// What the two passes over a file delivered.
struct Delivered {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;

  friend bool operator==(const Delivered& a, const Delivered& b) {
    return a.triangles == b.triangles &&
           std::equal(a.positions.begin(), a.positions.end(), b.positions.begin(),
                      b.positions.end(), same_bits);
  }

  /// A reader that delivers NaN shall deliver the same one.
  static bool same_bits(const Vec3& a, const Vec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }
};

bool is_packed(Input input) {
  const auto starts_with = [&](std::string_view magic) {
    return input.size() >= magic.size() &&
           std::memcmp(input.data(), magic.data(), magic.size()) == 0;
  };
  return starts_with("\x1f\x8b") || starts_with("\x28\xb5\x2f\xfd");
}

/// Windows of compressed files come out of it.
constexpr std::uint64_t kMemory = 32u << 20;

/// Reads with laws for each chunk.
class Reading {
 public:
  Reading(const std::filesystem::path& path, Input input)
      : budget_(kMemory),
        reader_(open_mesh_reader(path, &budget_)),
        most_(is_packed(input) ? SIZE_MAX : input.size()) {}

  IndexedMeshReader& reader() { return *reader_; }

  std::vector<Vec3> positions() {
    std::vector<Vec3> all;
    reader_->read_positions([&](std::span<const Vec3> chunk) { take(chunk, all); });
    return all;
  }
  std::vector<Triangle> triangles() {
    std::vector<Triangle> all;
    reader_->read_triangles([&](std::span<const Triangle> chunk) { take(chunk, all); });
    return all;
  }

 private:
  template <class T>
  void take(std::span<const T> chunk, std::vector<T>& all) {
    expect(!chunk.empty(), "a chunk has an element");
    expect(chunk.size() <= most_ - all.size(), "there are no more elements than bytes");
    const double fraction = reader_->pass_fraction();
    expect(fraction >= 0 && fraction <= 1, "the progress of a pass is a fraction");
    expect(reader_->bytes_read() <= reader_->bytes_total(), "no more is read than there is");
    all.insert(all.end(), chunk.begin(), chunk.end());
  }

  MemoryBudget budget_;
  std::unique_ptr<IndexedMeshReader> reader_;
  std::size_t most_;
};

/// A float is near each coordinate, or all three are NaN.
bool is_delivered_right(const Vec3& p) {
  const Vec3f q = to_float(p);
  if (std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z)) return true;
  return std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z);
}

void check_positions(const IndexedMeshReader& reader, const std::vector<Vec3>& positions,
                     Input input) {
  expect(std::all_of(positions.begin(), positions.end(), is_delivered_right),
         "positions are finite floats or not there at all");
  if (reader.positions_are_float()) {
    for (const Vec3& p : positions) {
      expect(Delivered::same_bits(widen(to_float(p)), p), "positions said to be floats are");
    }
  }
  const std::optional<PositionArray> array = reader.position_array();
  if (!array) return;
  expect(array->offset <= input.size() &&
             positions.size() <= (input.size() - array->offset) / sizeof(Vec3f),
         "an array of positions lies within the file");
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Vec3f p;
    std::memcpy(&p, input.data() + array->offset + i * sizeof p, sizeof p);
    const bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    expect(finite ? widen(p) == positions[i] : std::isnan(positions[i].x),
           "an array of positions is what is delivered");
  }
}

/// Rows of an element's attributes that are not pooled: whole ones, as many as there are elements.
void check_rows(IndexedMeshReader& reader, std::span<const AttributeSpec> specs, AttributePer per,
                std::size_t elements) {
  std::vector<AttributeSpec> direct = attributes_per(specs, per);
  std::erase_if(direct, [](const AttributeSpec& spec) { return spec.pooled; });
  const std::size_t width = channels(direct, per);
  if (width == 0) return;
  std::size_t numbers = 0;
  reader.read_attributes(per, [&](std::span<const double> rows) {
    expect(!rows.empty() && rows.size() % width == 0, "a chunk has whole rows");
    numbers += rows.size();
  });
  expect(numbers == elements * width, "each element has a row of attributes");
}

void check_pool(IndexedMeshReader& reader, const AttributeSpec& spec, std::size_t number,
                const Delivered& delivered) {
  std::size_t numbers = 0, uses = 0;
  reader.read_pool(number, [&](std::span<const double> rows) { numbers += rows.size(); });
  expect(numbers % spec.components.size() == 0, "a pool has whole values");
  const std::size_t values = numbers / spec.components.size();
  reader.read_pool_uses(number, [&](std::span<const PoolUse> corners) {
    for (const PoolUse& use : corners) {
      expect(use.value < values || use.value == PoolUse::kNone, "corners use values of the pool");
      expect(uses < 3 * delivered.triangles.size(), "there are no more uses than corners");
      expect(use.vertex == delivered.triangles[uses / 3][uses % 3],
             "uses come in the order of faces");
      ++uses;
    }
  });
  expect(uses == 3 * delivered.triangles.size(), "each corner has a use");
}

/// What a mesh carries besides its surface; the message where it is refused.
std::string read_extras(const std::filesystem::path& path, Input input,
                        const Delivered& delivered) {
  try {
    Reading reading(path, input);
    reading.positions();
    reading.triangles();
    IndexedMeshReader& reader = reading.reader();
    const std::vector<AttributeSpec> specs = reader.attributes();
    check_rows(reader, specs, AttributePer::vertex, delivered.positions.size());
    check_rows(reader, specs, AttributePer::face, delivered.triangles.size());
    check_rows(reader, specs, AttributePer::corner, 3 * delivered.triangles.size());
    for (std::size_t i = 0; i < specs.size(); ++i) {
      if (specs[i].pooled) check_pool(reader, specs[i], i, delivered);
    }
    const std::vector<std::string> names = reader.face_labels();
    if (names.empty()) return {};
    std::size_t labels = 0;
    reader.read_face_labels(names,
                            [&](std::span<const FaceLabel> chunk) { labels += chunk.size(); });
    expect(labels == delivered.triangles.size(), "each face has a label");
  } catch (const InputError& error) {
    return error.what();
  } catch (const BudgetError&) {
  }
  return {};
}

/// Both passes twice, or what is said when the file is refused.
std::optional<Delivered> read_forward(const std::filesystem::path& path, Input input,
                                      std::string& message) {
  try {
    Reading reading(path, input);
    Delivered first{reading.positions(), reading.triangles()};
    check_positions(reading.reader(), first.positions, input);
    for (const Triangle& t : first.triangles) {
      expect(std::max({t[0], t[1], t[2]}) < first.positions.size(), "indices are valid");
    }
    const Delivered again{reading.positions(), reading.triangles()};
    expect(again == first, "a second pass delivers the same");
    return first;
  } catch (const InputError& error) {
    message = error.what();
  } catch (const BudgetError&) {
    message.clear();
  }
  return std::nullopt;
}

std::optional<Delivered> read_triangles_first(const std::filesystem::path& path, Input input) {
  try {
    Reading reading(path, input);
    Delivered read;
    read.triangles = reading.triangles();
    read.positions = reading.positions();
    return read;
  } catch (const InputError&) {
  } catch (const BudgetError&) {
  }
  return std::nullopt;
}

void check_message(const std::string& message, const std::filesystem::path& path) {
  if (message.empty()) return;
  // From "accessor" on members of glTF's JSON.
  static constexpr std::array<std::string_view, 11> kPlaces = {
      "byte",  "line",   "header", "facet", "glTF", "accessor",
      "asset", "buffer", "mesh",   "node",  "scene"};
  const bool has_place = std::any_of(kPlaces.begin(), kPlaces.end(), [&](std::string_view place) {
    return message.find(place) != std::string::npos;
  });
  expect(message.starts_with(path.string()), "a refusal begins with the file: " + message);
  expect(has_place, "a refusal names a place: " + message);
  expect(message.size() < path.string().size() + 600, "a refusal is short: " + message);
  expect(std::none_of(message.begin(), message.end(), [](char c) { return c >= 0 && c < ' '; }),
         "a refusal has no control characters: " + message);
}

}  // namespace

void fuzz_mesh(Input input, std::string_view extension) {
  const std::filesystem::path path = scratch_directory() / ("input." + std::string(extension));
  write_file(path, input);
  std::string message;
  const std::optional<Delivered> forward = read_forward(path, input, message);
  check_message(message, path);
  const std::optional<Delivered> backward = read_triangles_first(path, input);
  expect(forward.has_value() == backward.has_value(),
         "a file is read or refused whatever the order of passes");
  if (!forward) return;
  expect(*forward == *backward, "the order of passes changes nothing");
  check_message(read_extras(path, input, *forward), path);
}

}  // namespace remaps::fuzz
