#include "remaps/repair/level_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "remaps/base/workers.h"

namespace remaps::repair {

/// Buffers of one worker thread.
struct LevelRepair::Lane {
  VertexIndex index;
  Segment segment;
  std::vector<FaceLink> origin;
  SegmentAnalysis analysis;
  std::vector<OrientedPart> part;               // (components)
  std::vector<std::uint8_t> shared;             // (components)
  std::vector<std::array<VertexId, 3>> corner;  // (faces) ids after the repair

  void load(DomainLevel& level, std::size_t i, DomainLevel::After after, EdgeRule rule) {
    level.load(i, index, segment, origin, after);
    analysis.run(segment, rule);
    weigh_components();
  }

 private:
  void weigh_components() {
    part.assign(analysis.components(), {});
    shared.assign(analysis.components(), 0);
    for (LocalIndex f = 0; f < segment.triangle.size(); ++f) {
      if (analysis.dropped()[f]) continue;
      const std::uint32_t c = analysis.component()[f];
      const LocalTriangle& t = segment.triangle[f];
      if (std::max({t[0], t[1], t[2]}) >= segment.own_vertices) shared[c] = 1;
      if (f < segment.home_faces) ++(analysis.turned()[f] ? part[c].turned : part[c].straight);
    }
  }
};

/// What a segment has to tell.
struct LevelRepair::Inspected {
  struct Note {
    std::uint32_t home;
    FaceId face;
    std::uint8_t slot;
    LocalIndex copy;
  };
  std::size_t segment = 0;
  Defects defects;
  DefectPlaces places;
  std::optional<std::pair<VertexId, VertexId>> one_sided;
  std::vector<OrientedPart> part;  // of the shared components
  std::vector<SharedFace> shared;
  std::vector<Note> notes;
  std::uint64_t copies = 0;
};

struct LevelRepair::Rewritten {
  struct Face {
    std::array<RoutedVertex, 3> corner;
    FaceId face;
    FaceLabel label;
  };
  std::vector<RoutedVertex> vertex;
  std::vector<VertexId> copy_of;  // (copies)
  std::vector<Face> face;
  RepairCounts counts;
};

LevelRepair::LevelRepair(DomainLevel& level, const RepairOptions& options, MemoryBudget& budget)
    : level_(level),
      options_(options),
      lanes_(std::max(1u, options.threads)),
      join_(options.temp_dir / "shared-faces", level.faces(), options.buffer_bytes / 2, budget),
      notes_(options.temp_dir / "copied-corners", level.segments(), options.buffer_bytes / 2,
             budget),
      reservation_(budget.reserve(level.segments() * 12, "repairing segments")),
      first_part_(level.segments()),
      first_copy_(level.segments()) {}

LevelRepair::~LevelRepair() = default;

void LevelRepair::report(std::size_t i, double from, double to) const {
  if (options_.progress == nullptr) return;
  options_.progress->advance(from + (to - from) * double(i + 1) / double(level_.segments()));
}

Findings LevelRepair::inspect() {
  run_ordered(level_.segments(), options_.threads, [this](std::size_t i, unsigned lane) -> Commit {
    if (options_.progress != nullptr) options_.progress->check();
    const std::shared_ptr<Inspected> part = inspect_segment(i, lanes_[lane]);
    return [this, i, part] {
      note(*part);
      report(i, 0, 0.5);
    };
  });
  if (const std::optional<FaceId> face = join_.finish(); face && findings_.one_sided.empty())
    findings_.one_sided = fmt::format("face {}", *face);
  return findings_;
}

std::shared_ptr<LevelRepair::Inspected> LevelRepair::inspect_segment(std::size_t i, Lane& lane) {
  lane.load(level_, i, DomainLevel::After::kKeep, options_.rule);
  const Segment& s = lane.segment;
  const SegmentAnalysis& found = lane.analysis;
  auto result = std::make_shared<Inspected>();
  result->segment = i;
  result->defects = found.defects();
  result->places = found.places();
  result->one_sided = found.one_sided();
  result->copies = found.copies().size();

  std::vector<std::uint32_t> number(lane.part.size(), kNoIndex);  // among the shared ones
  for (std::size_t c = 0; c < lane.part.size(); ++c) {
    if (!lane.shared[c]) continue;
    number[c] = static_cast<std::uint32_t>(result->part.size());
    result->part.push_back(lane.part[c]);
  }
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    const LocalTriangle& t = s.triangle[f];
    if (found.dropped()[f] || std::max({t[0], t[1], t[2]}) < s.own_vertices) continue;
    result->shared.push_back({s.face_id[f], number[found.component()[f]], found.turned()[f] != 0});
  }
  for (const SegmentAnalysis::CopiedCorner& c : found.copied_corners()) {
    if (c.face < s.home_faces) continue;
    std::uint32_t home = ~std::uint32_t{0};
    for (const LocalIndex v : s.triangle[c.face]) {
      home = std::min(home, v < s.own_vertices ? static_cast<std::uint32_t>(i)
                                               : level_.cut().segment_of(s.position[v]));
    }
    result->notes.push_back({home, s.face_id[c.face], static_cast<std::uint8_t>(c.slot), c.copy});
  }
  return result;
}

/// Takes in what a segment has to tell. In order of segments.
void LevelRepair::note(Inspected& part) {
  findings_.defects += part.defects;
  findings_.places.add(part.places);
  if (part.one_sided && findings_.one_sided.empty()) {
    findings_.one_sided = fmt::format("the edge between vertices {} and {}", part.one_sided->first,
                                      part.one_sided->second);
  }
  first_part_[part.segment] = join_.add(part.part, part.shared);
  first_copy_[part.segment] = copies_;
  for (const Inspected::Note& note : part.notes) {
    notes_.append_record(note.home, [&](store::Packer& packer) {
      packer.put40(note.face);
      packer.put(note.slot);
      packer.put40(copies_ + note.copy);
    });
  }
  copies_ += part.copies;
}

RepairCounts LevelRepair::rewrite(DomainLevel& out, VertexId first_copy,
                                  FunctionRef<void(std::span<const VertexId>)> copied) {
  RepairCounts counts;
  counts.dropped_components = join_.components_below(options_.min_component);
  run_ordered(level_.segments(), options_.threads, [&](std::size_t i, unsigned lane) -> Commit {
    if (options_.progress != nullptr) options_.progress->check();
    const std::shared_ptr<Rewritten> part = rewrite_segment(i, lanes_[lane], first_copy);
    return [&, i, part] {
      for (const RoutedVertex& v : part->vertex) out.add_vertex(v, {});
      copied(part->copy_of);
      for (const Rewritten::Face& f : part->face)
        out.add_face(f.corner, {f.face, 0, {}, 0, f.label});
      counts.dropped_duplicates += part->counts.dropped_duplicates;
      counts.flipped_faces += part->counts.flipped_faces;
      counts.split_vertices += part->counts.split_vertices;
      counts.dropped_components += part->counts.dropped_components;
      counts.dropped_component_faces += part->counts.dropped_component_faces;
      report(i, 0.5, 1);
    };
  });
  return counts;
}

std::vector<LevelRepair::Decision> LevelRepair::decide(std::size_t i, const Lane& lane) {
  std::vector<Decision> decision(lane.part.size());
  std::uint32_t shared = first_part_[i];
  for (std::size_t c = 0; c < decision.size(); ++c) {
    const OrientedPart& part = lane.part[c];
    std::uint64_t faces = part.straight + part.turned;
    decision[c].turn = part.turned > part.straight;
    decision[c].shared = lane.shared[c] != 0;
    if (lane.shared[c]) {
      decision[c].turn = join_.turns(shared);
      faces = join_.component_faces(shared++);
    }
    decision[c].drop = faces < options_.min_component;
  }
  return decision;
}

/// Puts in the copies that other segments made of their vertices.
void LevelRepair::apply_notes(std::size_t i, Lane& lane, VertexId first_copy) {
  store::Bytes bytes;
  notes_.take(i, bytes);
  if (bytes.empty()) return;
  const Segment& s = lane.segment;
  std::vector<std::pair<FaceId, LocalIndex>> local(s.home_faces);
  for (LocalIndex f = 0; f < s.home_faces; ++f) local[f] = {s.face_id[f], f};
  std::sort(local.begin(), local.end());
  store::Unpacker unpacker(bytes, "copied corners");
  while (!unpacker.done()) {
    const FaceId face = unpacker.get40();
    const auto slot = unpacker.get<std::uint8_t>();
    const VertexId copy = first_copy + unpacker.get40();
    const auto at = std::lower_bound(local.begin(), local.end(), std::pair{face, LocalIndex{0}});
    if (at == local.end() || at->first != face || slot > 2)
      throw CorruptionError("a copied corner is of a face that is not here");
    lane.corner[at->second][slot] = copy;
  }
}

std::shared_ptr<LevelRepair::Rewritten> LevelRepair::rewrite_segment(std::size_t i, Lane& lane,
                                                                     VertexId first_copy) {
  lane.load(level_, i, DomainLevel::After::kFree, options_.rule);
  const Segment& s = lane.segment;
  const SegmentAnalysis& found = lane.analysis;
  auto result = std::make_shared<Rewritten>();
  const auto segment = static_cast<std::uint32_t>(i);
  for (LocalIndex v = 0; v < s.own_vertices; ++v)
    result->vertex.push_back({s.vertex_id[v], s.position[v], segment});
  const std::vector<Decision> decision = decide(i, lane);
  const VertexId copies = first_copy + first_copy_[i];
  for (std::size_t c = 0; c < found.copies().size(); ++c)
    result->vertex.push_back({copies + c, s.position[found.copies()[c]], segment});
  for (const LocalIndex v : found.copies()) result->copy_of.push_back(s.vertex_id[v]);
  result->counts.split_vertices = found.copies().size();

  lane.corner.resize(s.triangle.size());
  for (LocalIndex f = 0; f < s.home_faces; ++f) {
    for (std::size_t k = 0; k < 3; ++k) lane.corner[f][k] = s.vertex_id[s.triangle[f][k]];
  }
  for (const SegmentAnalysis::CopiedCorner& c : found.copied_corners())
    lane.corner[c.face][c.slot] = copies + c.copy;
  apply_notes(i, lane, first_copy);

  for (const Decision& d : decision) result->counts.dropped_components += d.drop && !d.shared;
  for (LocalIndex f = 0; f < s.home_faces; ++f) {
    if (found.dropped()[f]) {
      ++result->counts.dropped_duplicates;
      continue;
    }
    const Decision& d = decision[found.component()[f]];
    if (d.drop) {
      ++result->counts.dropped_component_faces;
      continue;
    }
    std::array<RoutedVertex, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      const LocalIndex v = s.triangle[f][k];
      corner[k] = {lane.corner[f][k], s.position[v],
                   v < s.own_vertices ? segment : level_.cut().segment_of(s.position[v])};
    }
    if (d.turn != (found.turned()[f] != 0)) {
      std::swap(corner[1], corner[2]);
      ++result->counts.flipped_faces;
    }
    result->face.push_back({corner, s.face_id[f], s.label.empty() ? kNoLabel : s.label[f]});
  }
  return result;
}

}  // namespace remaps::repair
