#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "remaps/codec/subdivision_hierarchy.h"
#include "support/shapes.h"

namespace remaps::test {

/// A base mesh to subdivide, and what its surface is.
struct CodecBase {
  std::string name;
  std::vector<Vec3> position;
  std::vector<codec::Face> face;
  int euler_characteristic = 2;
  bool boundary = false;

  std::uint32_t vertices() const { return static_cast<std::uint32_t>(position.size()); }
};

CodecBase base_of(const Shape& shape);
/// Closed ones of genus 0, 1, 2, with boundary, of two components; valences from 3 to 14. All but
/// the double torus are the subdivision of no mesh.
std::vector<CodecBase> codec_bases();

/// The faces of the finest level.
std::vector<codec::Face> finest_faces(const codec::SubdivisionHierarchy& hierarchy);

/// Values from -1 to 1.
std::vector<Vec3> random_values(std::size_t count, std::mt19937_64& random);

}  // namespace remaps::test
