#include "remaps/mesh/face_labels.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>

#include "remaps/base/errors.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps {
namespace {

FaceLabel proper(std::uint64_t hash) {
  return hash == kNoLabel ? 1 : hash;
}

/// Attributes of faces that tell parts from each other.
bool tells_parts(const AttributeSpec& spec) {
  return spec.per == AttributePer::face && !spec.pooled &&
         (spec.kind == AttributeKind::label || spec.kind == AttributeKind::colour);
}

}  // namespace

FaceLabel mix_label(FaceLabel label, std::string_view value) {
  return proper(XXH3_64bits_withSeed(value.data(), value.size(), label));
}

FaceLabel mix_label(FaceLabel label, std::uint64_t value) {
  return proper(XXH3_64bits_withSeed(&value, sizeof value, label));
}

FaceLabelChoice::FaceLabelChoice(std::string_view text) : all_(text == "all") {
  if (all_ || text == "none") return;
  for (;;) {
    const std::size_t end = std::min(text.find(','), text.size());
    if (end == 0) throw InputError("expected all, none or names of labels, found an empty name");
    names_.emplace_back(text.substr(0, end));
    if (end == text.size()) return;
    text.remove_prefix(end + 1);
  }
}

std::vector<std::string> FaceLabelChoice::choose(std::span<const std::string> there,
                                                 std::string_view file) const {
  if (all_) return {there.begin(), there.end()};
  for (const std::string& name : names_) {
    if (std::find(there.begin(), there.end(), name) != there.end()) continue;
    throw InputError(fmt::format(
        "{}: its faces have no label '{}'; {}", file, name.substr(0, 80),
        there.empty() ? "they have none at all"
                      : fmt::format("there are {}", fmt::join(there.begin(), there.end(), ", "))));
  }
  std::vector<std::string> chosen;
  std::copy_if(there.begin(), there.end(), std::back_inserter(chosen), [&](const auto& name) {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  });
  return chosen;
}

std::vector<std::string> IndexedMeshReader::face_labels() {
  std::vector<std::string> names;
  for (const AttributeSpec& spec : attributes()) {
    if (tells_parts(spec)) names.push_back(spec.name);
  }
  return names;
}

void IndexedMeshReader::read_face_labels(std::span<const std::string> names, FaceLabelSink sink) {
  const std::vector<AttributeSpec> faces = attributes_per(attributes(), AttributePer::face);
  std::vector<std::size_t> channel;
  std::size_t channels = 0;
  for (const AttributeSpec& spec : faces) {
    if (spec.pooled) continue;
    const bool wanted =
        tells_parts(spec) && std::find(names.begin(), names.end(), spec.name) != names.end();
    for (std::size_t i = 0; i < spec.components.size(); ++i, ++channels) {
      if (wanted) channel.push_back(channels);
    }
  }
  std::vector<FaceLabel> labels;
  read_attributes(AttributePer::face, [&](std::span<const double> rows) {
    labels.clear();
    for (; !rows.empty(); rows = rows.subspan(channels)) {
      FaceLabel label = kNoLabel;
      for (const std::size_t c : channel)
        label = mix_label(label, std::bit_cast<std::uint64_t>(rows[c] + 0.0));
      labels.push_back(label);
    }
    sink(labels);
  });
}

}  // namespace remaps
