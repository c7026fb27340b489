#pragma once

#include <cstdint>
#include <vector>

#include "remaps/mesh/indexed_stream.h"
#include "remaps/pipeline/weld_files.h"

namespace remaps::pipeline {

/// The attributes of a mesh whose vertices were welded, from those of the mesh before.
///
/// Faces and corners keep theirs. Of vertices, colours, scalars and labels are those of the first
/// of the vertices that became one. Normals become the mean over the corners there, and texture
/// coordinates become those of corners: where vertices were apart for the sake of a seam, it stays.
/// Both go through pools, whose values are the rows of the mesh before, in its order.
class WeldedAttributes {
 public:
  /// All of them outlive the object.
  /// @param numbers  of the vertices before, where they went
  /// @param corners  of all faces, three each, where they went
  WeldedAttributes(IndexedMeshReader& source, NumberFile& numbers, NumberFile& corners)
      : source_(source), numbers_(numbers), corners_(corners) {}

  // As in IndexedMeshReader.
  std::vector<AttributeSpec> attributes();
  void read_attributes(AttributePer per, AttributeSink sink);
  void read_pool(std::size_t number, AttributeSink sink);
  void read_pool_uses(std::size_t number, PoolUseSink sink);

 private:
  /// Whether an attribute of the source becomes one of corners, or a mean over them.
  static bool changes(const AttributeSpec& spec) {
    return spec.per == AttributePer::vertex && !spec.pooled &&
           (spec.kind == AttributeKind::normal || spec.kind == AttributeKind::uv);
  }
  void read_first_rows(AttributeSink sink);

  IndexedMeshReader& source_;
  NumberFile& numbers_;
  NumberFile& corners_;
  std::vector<AttributeSpec> specs_;  // of the source, once asked for
};

}  // namespace remaps::pipeline
