#include "remaps/pipeline/mesh_signals.h"

#include <algorithm>
#include <utility>

namespace remaps::pipeline {
namespace {

using codec::SignalKind;

std::optional<SignalKind> signal_kind(const AttributeSpec& spec) {
  if (spec.per != AttributePer::vertex || spec.components.size() < 3) return std::nullopt;
  if (spec.kind == AttributeKind::colour) return SignalKind::kColour;
  if (spec.kind == AttributeKind::normal) return SignalKind::kNormal;
  return std::nullopt;
}

}  // namespace

std::vector<AttributeSpec> choose_signals(const std::optional<AttributeChoice>& choice,
                                          std::span<const AttributeSpec> specs,
                                          std::string_view file) {
  const auto wanted =
      choice ? choice->choose(specs, file) : std::vector<AttributeSpec>(specs.begin(), specs.end());
  std::vector<AttributeSpec> chosen;
  for (const AttributeSpec& spec : wanted) {
    const auto kind = signal_kind(spec);
    if (!kind || (!choice && *kind != SignalKind::kColour)) continue;
    const bool has_one = std::any_of(chosen.begin(), chosen.end(), [&](const AttributeSpec& other) {
      return signal_kind(other) == kind;
    });
    if (!has_one) chosen.push_back(spec);
  }
  return chosen;
}

MeshCollector::MeshCollector(std::vector<AttributeSpec> specs, std::size_t vertices)
    : specs_(std::move(specs)), row_(channels(specs_, AttributePer::vertex)) {
  positions.reserve(vertices);
  for (const AttributeSpec& spec : specs_) {
    signals.push_back({*signal_kind(spec), {}});
    signals.back().value.reserve(vertices);
  }
}

void MeshCollector::write_positions(std::span<const Vec3> part) {
  positions.insert(positions.end(), part.begin(), part.end());
}

void MeshCollector::write_attributes(AttributePer per, std::span<const std::byte> rows) {
  if (per != AttributePer::vertex) return;
  const std::size_t bytes = row_bytes(specs_, per);
  for (; !rows.empty(); rows = rows.subspan(bytes)) {
    unpack_row(specs_, rows.first(bytes), row_);
    take(row_);
  }
}

void MeshCollector::take(std::span<const double> row) {
  for (std::size_t i = 0; i < specs_.size(); ++i) {
    const AttributeSpec& spec = specs_[i];
    const bool colour = spec.kind == AttributeKind::colour;
    const auto value = [&](std::size_t c) {
      return colour ? row[c] / full_colour(spec.components[c].type) : row[c];
    };
    signals[i].value.push_back({value(0), value(1), value(2)});
    row = row.subspan(spec.components.size());
  }
}

AttributeSpec spec_of(SignalKind kind) {
  if (kind == SignalKind::kColour) {
    return {
        "colour",
        AttributeKind::colour,
        AttributePer::vertex,
        {{"red", ScalarType::uint8}, {"green", ScalarType::uint8}, {"blue", ScalarType::uint8}}};
  }
  return {"normal", AttributeKind::normal, AttributePer::vertex, {{"nx"}, {"ny"}, {"nz"}}};
}

void pack_signals(std::span<const std::uint32_t> vertices,
                  std::span<const codec::Signal* const> signals,
                  std::span<const AttributeSpec> specs, std::vector<std::byte>& rows) {
  const std::size_t bytes = row_bytes(specs, AttributePer::vertex);
  std::vector<double> row;
  rows.resize(vertices.size() * bytes);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    row.clear();
    for (const codec::Signal* signal : signals) {
      const double scale = signal->kind == SignalKind::kColour ? 255 : 1;
      const Vec3 value = scale * signal->value[vertices[i]];
      row.insert(row.end(), {value.x, value.y, value.z});
    }
    pack_row(specs, row, std::span(rows).subspan(i * bytes, bytes));
  }
}

}  // namespace remaps::pipeline
