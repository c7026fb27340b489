#pragma once

#include <array>
#include <map>
#include <vector>

#include "support/remesh_job.h"

/// What welding should do, on lists.
namespace remaps::test {

/// Each face with corners of its own.
inline MeshLists soup_of(const MeshLists& mesh) {
  MeshLists soup;
  for (const Triangle& t : mesh.triangle) {
    const VertexId first = soup.position.size();
    for (const VertexId v : t) soup.position.push_back(mesh.position[v]);
    soup.triangle.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// By definition: `root` tells where each vertex goes at last.
inline MeshLists expected_of(const MeshLists& mesh, const std::vector<VertexId>& root) {
  MeshLists welded;
  std::vector<VertexId> number(mesh.position.size());
  for (VertexId v = 0; v < root.size(); ++v) {
    if (root[v] == v) {
      number[v] = welded.position.size();
      welded.position.push_back(mesh.position[v]);
    } else {
      number[v] = number[root[v]];
    }
  }
  for (const Triangle& t : mesh.triangle)
    welded.triangle.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return welded;
}

inline std::vector<VertexId> equal_roots(const MeshLists& mesh) {
  std::map<std::array<double, 3>, VertexId> first;
  std::vector<VertexId> root;
  for (const Vec3& p : mesh.position)
    root.push_back(first.try_emplace({p.x, p.y, p.z}, root.size()).first->second);
  return root;
}

}  // namespace remaps::test
