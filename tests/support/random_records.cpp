#include "support/random_records.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace remaps::test {
namespace {

double shape_of(GridPoint a, GridPoint b, GridPoint c) {
  const auto squared = [](GridPoint p, GridPoint q) {
    return std::pow(double(p.x) - q.x, 2) + std::pow(double(p.y) - q.y, 2);
  };
  const double longest = std::max({squared(a, b), squared(b, c), squared(c, a)});
  return longest > 0 ? orientation(a, b, c) / longest : 0;
}

bool wedges_are_valid(const Retriangulation& r, double floor) {
  for (unsigned i = 0; i < r.wedges; ++i) {
    if (!(shape_of({}, r.ring[i], r.ring[r.next(i)]) >= floor)) return false;
  }
  return true;
}

bool fan_is_valid(const Retriangulation& r, double floor) {
  for (unsigned j = 0; j < r.triangles(); ++j) {
    if (!(shape_of(r.ring[r.corner(j, 0)], r.ring[r.corner(j, 1)], r.ring[r.corner(j, 2)]) >=
          floor))
      return false;
  }
  return true;
}

void draw_ring(std::mt19937_64& random, Retriangulation& r) {
  std::uniform_real_distribution<double> unit(0, 1);
  const unsigned n = r.ring_size();
  const double span = (r.boundary ? 1 : 2) * std::numbers::pi;
  std::vector<double> angle(n);
  for (double& a : angle) a = span * unit(random);
  std::sort(angle.begin(), angle.end());
  const double least = 1 - 0.9 * unit(random);
  for (unsigned i = 0; i < n; ++i) {
    if (r.boundary && i == 0) angle[i] = 0;
    if (r.boundary && i + 1 == n) angle[i] = span;
    const double radius = kGridRadius * (least + (1 - least) * unit(random));
    r.ring[i] = {static_cast<std::int16_t>(std::lrint(radius * std::cos(angle[i]))),
                 static_cast<std::int16_t>(std::lrint(radius * std::sin(angle[i])))};
  }
}

}  // namespace

Retriangulation random_record(std::mt19937_64& random, bool boundary, LocalIndex faces,
                              double floor) {
  Retriangulation r;
  r.boundary = boundary;
  while (true) {
    const unsigned least = boundary ? 2 : 3;
    r.wedges = static_cast<std::uint8_t>(least + random() % 7);
    draw_ring(random, r);
    if (!wedges_are_valid(r, floor)) continue;
    std::vector<std::uint8_t> apexes;
    for (unsigned apex = 0; apex < r.ring_size(); ++apex) {
      r.apex = static_cast<std::uint8_t>(apex);
      if (fan_is_valid(r, floor)) apexes.push_back(r.apex);
    }
    if (apexes.empty()) continue;
    r.apex = apexes[random() % apexes.size()];
    break;
  }
  for (unsigned i = 0; i < r.wedges; ++i) {
    do {
      r.face[i] = static_cast<LocalIndex>(random() % faces);
    } while (std::find(r.face.begin(), r.face.begin() + i, r.face[i]) != r.face.begin() + i);
    r.turn[i] = static_cast<std::uint8_t>(random() % 3);
  }
  return r;
}

SegmentLog random_segment_log(std::mt19937_64& random, unsigned level, std::size_t records) {
  SegmentLog log;
  log.level = level;
  log.faces = static_cast<LocalIndex>(20 + random() % 500);
  if (level > 0) {
    for (LocalIndex f = 0; f < log.faces; ++f) {
      log.origin.push_back(
          {static_cast<std::uint32_t>(random() % 9), static_cast<LocalIndex>(random() % 100'000)});
    }
  }
  for (std::size_t r = 0; r < records; ++r) {
    log.records.append(random_record(random, random() % 4 == 0, log.faces));
    log.removed.push_back(random() >> 25);
  }
  for (LocalIndex f = 0; f < log.faces; ++f) {
    if (random() % 3 == 0) continue;
    log.survivor.push_back(f);
    log.next.push_back(
        {static_cast<std::uint32_t>(random() % 9), static_cast<LocalIndex>(random() % 100'000)});
  }
  return log;
}

}  // namespace remaps::test
