#include "remaps/map/base_carrier.h"

#include <algorithm>

#include "remaps/base/workers.h"

namespace remaps::map {

BaseCarrier::BaseCarrier(std::span<const store::SectionFile* const> logs, std::uint64_t cache_bytes,
                         MemoryBudget& budget)
    : cache_bytes_(cache_bytes),
      reservation_(budget.reserve(cache_bytes, "logs that vertices pass through")) {
  for (const store::SectionFile* log : logs) levels_.emplace_back(*log);
}

std::shared_ptr<const LoadedSegment> BaseCarrier::get(std::size_t level, std::size_t segment) {
  const std::scoped_lock lock(mutex_);
  ++clock_;
  for (Entry& entry : cache_) {
    if (entry.level != level || entry.segment != segment) continue;
    entry.used = clock_;
    return entry.loaded;
  }
  if (segment >= levels_[level].segments())
    throw CorruptionError("a log leads to a segment that does not exist");
  const std::uint64_t expected = levels_[level].expected_bytes(segment);
  while (!cache_.empty() && held_bytes_ + expected > cache_bytes_) {
    const auto oldest =
        std::min_element(cache_.begin(), cache_.end(),
                         [](const Entry& a, const Entry& b) { return a.used < b.used; });
    held_bytes_ -= oldest->loaded->bytes();
    cache_.erase(oldest);
  }
  const auto loaded = levels_[level].load(segment, SegmentMap::Direction::kForward);
  cache_.push_back({level, segment, clock_, loaded});
  held_bytes_ += loaded->bytes();
  return loaded;
}

/// Carries vertices from the near side of a level on to the base.
void BaseCarrier::carry_on(std::size_t level, std::span<Vertex> vertices) {
  std::vector<FacePoint> points;
  for (; level < levels_.size(); ++level) {
    std::span<Vertex> rest = vertices;
    while (!rest.empty()) {
      const std::uint32_t segment = rest.front().at.segment;
      const auto end = std::partition(rest.begin(), rest.end(), [&](const Vertex& vertex) {
        return vertex.at.segment == segment;
      });
      const auto here = rest.first(static_cast<std::size_t>(end - rest.begin()));
      rest = rest.subspan(here.size());
      const auto loaded = get(level, segment);
      points.clear();
      for (const Vertex& vertex : here) points.push_back({vertex.at.face, vertex.u, vertex.v});
      loaded->carry(points);
      for (std::size_t i = 0; i < here.size(); ++i) {
        here[i].at = loaded->link[points[i].face];
        here[i].u = points[i].u;
        here[i].v = points[i].v;
      }
    }
  }
}

std::vector<BaseCarrier::Vertex> BaseCarrier::carry_segment(std::size_t level,
                                                            std::size_t segment) {
  const auto loaded = levels_[level].load(segment, SegmentMap::Direction::kForward);
  std::vector<FacePoint> points(loaded->map.records());
  loaded->map.carry_removed(points);
  std::vector<Vertex> vertices;
  vertices.reserve(points.size());
  for (std::size_t r = 0; r < points.size(); ++r) {
    vertices.push_back(
        {loaded->link[points[r].face], points[r].u, points[r].v, loaded->log.removed[r]});
  }
  carry_on(level + 1, vertices);
  return vertices;
}

void BaseCarrier::carry_removed(const CarryOptions& options, const BaseSink& sink) {
  std::vector<std::pair<std::size_t, std::size_t>> tasks;
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    for (std::size_t s = 0; s < levels_[level].segments(); ++s) tasks.emplace_back(level, s);
  }
  run_ordered(tasks.size(), options.threads, [&](std::size_t i, unsigned) -> Commit {
    if (options.progress != nullptr) options.progress->check();
    auto vertices =
        std::make_shared<std::vector<Vertex>>(carry_segment(tasks[i].first, tasks[i].second));
    return [&, vertices, i] {
      for (const Vertex& vertex : *vertices) sink(vertex.id, {vertex.at.face, vertex.u, vertex.v});
      if (options.progress != nullptr)
        options.progress->advance(double(i + 1) / double(tasks.size()));
    };
  });
}

}  // namespace remaps::map
