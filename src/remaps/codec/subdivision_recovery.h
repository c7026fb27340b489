#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/codec/subdivision_hierarchy.h"

namespace remaps::codec {

struct SemiRegularConnectivity {
  std::uint32_t base_vertices = 0;
  std::vector<Face> base;             ///< (base faces) numbers of base vertices
  unsigned levels = 0;                ///< of subdivision
  std::vector<std::uint32_t> vertex;  ///< (vertices) number in the given mesh of each vertex of
                                      ///< SubdivisionHierarchy(base_vertices, base, levels)
};

/// Finds the base mesh that a mesh is the 1-to-4 subdivision of, level by level, as deep as it
/// goes, whatever the order of its vertices, faces and corners.
///
/// All components get the same number of levels. Where several bases are possible, as on a regular
/// torus, one that goes deepest is taken, among those the first by the part that the first face
/// plays. Base faces that follow each other are mostly neighbours; the first is the one with face 0
/// of the mesh, and of a mesh in the order of its hierarchy, base and numbers come back as they
/// were if they came from here.
///
/// @param faces         (f) corners, counter-clockwise: an oriented manifold, with or without
///                      boundary
/// @param least_levels  what is less is refused
/// @param most_levels   where to stop
/// @throws GeometryError  the mesh is not of that kind, or has not so many levels; says why
/// @throws BudgetError    it does not fit: some 140 bytes a face
/// Cost: linear; for a component that stays regular everywhere, proportional to the faces and the
/// levels. Deterministic.
/// Source: as Taubin, Detecting and Reconstructing Subdivision Connectivity (The Visual Computer
/// 18, 2002), in what it finds. Differs: the part of one face in its coarse face decides all others
/// of a component, so that four trials do and no covering mesh is built.
SemiRegularConnectivity recover_subdivision(std::uint32_t vertices, std::span<const Face> faces,
                                            unsigned least_levels, unsigned most_levels,
                                            MemoryBudget& budget);

}  // namespace remaps::codec
