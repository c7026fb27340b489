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

/// Reads with laws for each chunk.
class Reading {
 public:
  Reading(const std::filesystem::path& path, Input input)
      : reader_(open_mesh_reader(path)), most_(is_packed(input) ? SIZE_MAX : input.size()) {}

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
  if (forward) expect(*forward == *backward, "the order of passes changes nothing");
}

}  // namespace remaps::fuzz
