#include "remaps/pipeline/push_forward.h"

#include <fmt/format.h>

namespace remaps::pipeline {

std::unique_ptr<map::PointBuckets> make_points(const Bundle& bundle, std::size_t level,
                                               const PushOptions& options, MemoryBudget& budget) {
  return std::make_unique<map::PointBuckets>(options.temp_dir / fmt::format("forward-{}", level),
                                             bundle.log(level).sections() / 2,
                                             options.buffer_bytes / 2, budget);
}

void push_forward(const Bundle& bundle, std::unique_ptr<map::PointBuckets> points,
                  const PushOptions& options, MemoryBudget& budget,
                  const std::function<void(const map::TaggedPoint&)>& sink) {
  const std::size_t levels = bundle.manifest().levels;
  for (std::size_t level = 0; level < levels; ++level) {
    const bool last = level + 1 == levels;
    std::unique_ptr<map::PointBuckets> next;
    if (!last) next = make_points(bundle, level + 1, options, budget);
    const auto refuse = [&](const char* what) {
      throw CorruptionError(fmt::format("{}: leads to a {} that does not exist",
                                        bundle.log(level).path().string(), what));
    };
    map::carry_points(map::LevelMap(bundle.log(level)), map::SegmentMap::Direction::kForward,
                      *points, options.carry,
                      [&](const FaceLink& link, const map::TaggedPoint& point) {
                        if (last) {
                          if (link.face >= bundle.base().triangle.size()) refuse("base face");
                          sink(point);
                        } else {
                          if (link.segment >= next->segments()) refuse("segment");
                          next->add(link.segment, point);
                        }
                      });
    points = std::move(next);
  }
}

}  // namespace remaps::pipeline
