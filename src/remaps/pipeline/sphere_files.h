#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/map/segment_map.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/sphere/spherical_map.h"
#include "remaps/sphere/surface_components.h"

namespace remaps::pipeline {

/// What sphere.json says of a component that is mapped. Format: docs/formats/sphere.md.
struct SphereComponent {
  sphere::SurfaceComponent base;     ///< of the base mesh
  sphere::SphericalQuality quality;  ///< of the base mesh on the sphere
};

struct SphereManifest {
  std::vector<SphereComponent> components;  ///< that are mapped: the largest ones of the base
  std::uint64_t vertices = 0;               ///< of the input that are mapped
  double round_trip_max = 0;  ///< of these: base to sphere to base, fraction of the diagonal
};

inline constexpr const char* kSphereManifestName = "sphere.json";
inline constexpr const char* kSphereName = "sphere.bin";
inline constexpr const char* kSphereBaseName = "sphere-base.bin";

/// Refuses what is no sphere.
/// @param number, of  which one it is of so many, by size, for the message
/// @throws GeometryError  names genus and boundary loops
void check_is_sphere(const sphere::SurfaceComponent& component, std::size_t number, std::size_t of);

/// Maps the base of a bundle to the sphere, or some of its components to one each, and adds
/// sphere.json, sphere.bin and sphere-base.bin to the bundle's directory.
///
/// @param all  every component, not only the one that has most base faces
/// @throws GeometryError  a component is not closed or not of genus 0: names genus and loops
/// Cost: parameterize_sphere, and a pass over map.bin. Memory: that of the base, and buffers.
SphereManifest add_sphere(const Bundle& bundle, bool all, MemoryBudget& budget, Progress& progress);

bool has_sphere(const Bundle& bundle);

/// The spherical map of a bundle, open for reading. Each check of SphericalMap is made.
/// @throws InputError  the bundle has none; CorruptionError: damaged, or made for another bundle
class SphereFiles {
 public:
  SphereFiles(const Bundle& bundle, MemoryBudget& budget);

  const SphereManifest& manifest() const { return manifest_; }
  const sphere::SphericalMap& map() const { return *map_; }
  /// Compares sphere.bin with what map.bin and the map say of each vertex: the same bits.
  /// @throws CorruptionError  names the first vertex that differs
  void check_vertices(const Bundle& bundle, Progress& progress) const;

 private:
  SphereManifest manifest_;
  std::uint64_t sphere_checksum_ = 0;
  Reservation memory_;
  std::optional<sphere::SphericalMap> map_;
};

}  // namespace remaps::pipeline
