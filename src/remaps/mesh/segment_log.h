#pragma once

#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/retriangulation.h"
#include "remaps/store/packing.h"

namespace remaps {

/// A face of a level: its segment and its local id there.
struct FaceLink {
  std::uint32_t segment = 0;
  LocalIndex face = 0;

  friend bool operator==(const FaceLink&, const FaceLink&) = default;
};

/// What a sweep did to one segment. Two sections of the level's log file: the first is known when
/// the segment is done, the second (`survivor`, `next`) when it is committed. Byte-level format:
/// docs/formats/log.md.
struct SegmentLog {
  std::uint32_t level = 0;
  LocalIndex faces = 0;  ///< home faces before the first record; local ids are below
  std::vector<FaceLink>
      origin;  ///< (faces) the same faces at the end of the sweep before; empty at level 0
  RetriangulationLog records;        ///< in removal order
  std::vector<VertexId> removed;     ///< (records) input index of each removed vertex
  std::vector<LocalIndex> survivor;  ///< (s) local ids of the faces that are left, ascending
  std::vector<FaceLink>
      next;  ///< (s) the same faces at the next level; at the last: segment 0, base face

  void clear();
};

/// Sections 2 i and 2 i + 1 of segment i.
store::Bytes encode_records(const SegmentLog& log);
store::Bytes encode_survivors(const SegmentLog& log);

/// Reads both back; every id, count and link is checked.
/// @throws CorruptionError  names `what`
void decode_records(store::ByteSpan bytes, const std::string& what, SegmentLog& log);
void decode_survivors(store::ByteSpan bytes, const std::string& what, SegmentLog& log);

/// A first-level segment's home faces with the positions of their corners: the input, sorted by
/// place. What a sample is looked up on. Byte-level format: docs/formats/tiles.md.
struct Tile {
  LocalIndex own_vertices = 0;                      ///< the first so many belong to this tile
  std::vector<VertexId> vertex_id;                  ///< (v) input index
  std::vector<Vec3f> position;                      ///< (v)
  std::vector<std::array<LocalIndex, 3>> triangle;  ///< (f) local
  std::vector<FaceId> face_id;                      ///< (f) input index

  void clear();
};

store::Bytes encode_tile(const Tile& tile);
/// @throws CorruptionError  names `what`
void decode_tile(store::ByteSpan bytes, const std::string& what, Tile& tile);

/// Reads all but the ids, whose lists are left empty and are not checked.
/// @throws CorruptionError  names `what`
void decode_tile_surface(store::ByteSpan bytes, const std::string& what, Tile& tile);

/// Reads the face ids alone: the rest is passed over, not decoded.
/// @throws CorruptionError  names `what`
void decode_tile_face_ids(store::ByteSpan bytes, const std::string& what,
                          std::vector<FaceId>& face_id);

inline constexpr std::array<char, 4> kLogKind{'l', 'o', 'g', '1'};
inline constexpr std::array<char, 4> kTileKind{'t', 'i', 'l', 'e'};

}  // namespace remaps
