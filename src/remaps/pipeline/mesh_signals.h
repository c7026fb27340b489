#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "remaps/codec/semi_regular_mesh.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps::pipeline {

/// Attributes that an archive can hold as signals, at most one of each kind: those asked for, or
/// colours.
/// @throws InputError  a name that is not there
std::vector<AttributeSpec> choose_signals(const std::optional<AttributeChoice>& choice,
                                          std::span<const AttributeSpec> specs,
                                          std::string_view file);

/// Takes a mesh that is written, and keeps it: positions, and the signals of its vertices.
class MeshCollector final : public IndexedMeshWriter {
 public:
  /// @param specs     out of choose_signals
  /// @param vertices  about as many will come
  MeshCollector(std::vector<AttributeSpec> specs, std::size_t vertices);

  void write_positions(std::span<const Vec3> part) override;
  void write_attributes(AttributePer per, std::span<const std::byte> rows) override;
  void write_triangles(std::span<const Triangle>) override {}
  void close() override {}

  /// The values of one vertex, as many as the attributes have components.
  void take(std::span<const double> row);

  std::vector<Vec3> positions;
  std::vector<codec::Signal> signals;

 private:
  std::vector<AttributeSpec> specs_;
  std::vector<double> row_;
};

/// How a signal is written: colours as three uint8, normals as three floats.
AttributeSpec spec_of(codec::SignalKind kind);

/// The rows of some vertices.
/// @param signals  of which each has its spec_of
void pack_signals(std::span<const std::uint32_t> vertices,
                  std::span<const codec::Signal* const> signals,
                  std::span<const AttributeSpec> specs, std::vector<std::byte>& rows);

}  // namespace remaps::pipeline
