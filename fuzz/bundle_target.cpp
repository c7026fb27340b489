#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "fuzz_targets.h"
#include "remaps/base/errors.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/query.h"
#include "seed_bundle.h"

namespace remaps::fuzz {
namespace {

/// Calls a question to a bundle: its answer, or nothing if the bundle is refused.
template <class Question>
auto ask(Question question) -> std::optional<decltype(question())> {
  try {
    return question();
  } catch (const CorruptionError&) {
  } catch (const InputError&) {
  } catch (const GeometryError&) {
  } catch (const BudgetError&) {
  }
  return std::nullopt;
}

/// The bundle with one part replaced, as long as the object lives.
class Replaced {
 public:
  Replaced(const SeedBundle& bundle, BundlePart part, Input content)
      : bundle_(bundle), part_(part) {
    bundle_.write_with(part_, content);
  }
  ~Replaced() { bundle_.restore(part_); }
  Replaced(const Replaced&) = delete;
  Replaced& operator=(const Replaced&) = delete;

 private:
  const SeedBundle& bundle_;
  BundlePart part_;
};

bool is_finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void check_bundle(const std::filesystem::path& directory) {
  pipeline::QueryOptions options;
  options.bundle = directory;
  options.temp_dir = scratch_directory();
  options.memory_bytes = 24 << 20;
  options.threads = 1;
  Progress progress;
  const auto counts = ask([&] {
    const pipeline::Bundle bundle(directory);
    return std::pair(bundle.manifest().input_vertices, bundle.base().triangle.size());
  });
  if (!counts) return;

  const auto sound = ask([&] { return pipeline::verify_bundle(options, progress); });
  const auto middle_face = static_cast<std::uint32_t>(counts->second / 2);
  const auto of_base = ask([&] {
    return pipeline::locate_base_points(options, {{0, 0.25, 0.5}, {middle_face, 1, 0}}, progress);
  });
  const auto of_input = ask([&] {
    return pipeline::locate_input_points(options, {{0, 0.25, 0.5, {}}}, progress);
  });
  const auto of_vertices = ask([&] {
    return pipeline::locate_vertices(options, {0, counts->first / 2}, progress);
  });
  if (!sound) return;
  expect(of_base && of_input, "what is sound can be followed");
  for (const auto& found : {of_base, of_input, of_vertices}) {
    if (!found) continue;  // a vertex without a face
    for (const pipeline::Location& location : *found) {
      expect(is_finite(location.position) && is_finite(location.base_position),
             "what is sound leads to places");
    }
  }
}

}  // namespace

void fuzz_bundle(Input input) {
  if (input.empty()) return;
  static const SeedBundle bundle;
  const auto part = static_cast<BundlePart>(static_cast<unsigned>(input[0]) % kBundleParts);
  const Replaced replaced(bundle, part, input.subspan(1));
  check_bundle(bundle.directory());
}

}  // namespace remaps::fuzz
