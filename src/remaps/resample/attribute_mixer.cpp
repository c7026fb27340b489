#include "remaps/resample/attribute_mixer.h"

#include <cmath>
#include <utility>

namespace remaps::resample {

AttributeMixer::AttributeMixer(std::vector<AttributeSpec> specs) : specs_(std::move(specs)) {
  row_bytes_ = 0;
  for (const AttributeSpec& spec : specs_) {
    row_bytes_ += remaps::row_bytes(spec);
    if (spec.kind == AttributeKind::normal && spec.components.size() == 3) {
      normal_.push_back(label_.size());
    }
    label_.insert(label_.end(), spec.components.size(), spec.kind == AttributeKind::label);
  }
  values_.resize(label_.size());
}

void AttributeMixer::add(std::span<const std::byte> row, double weight, std::span<double> sum,
                         double& heaviest) {
  unpack_row(specs_, row, values_);
  const bool nearest = weight > heaviest;
  for (std::size_t c = 0; c < label_.size(); ++c) {
    if (!label_[c]) {
      sum[c] += weight * values_[c];
    } else if (nearest) {
      sum[c] = values_[c];
    }
  }
  if (nearest) heaviest = weight;
}

void AttributeMixer::finish(std::span<double> sum, std::span<std::byte> row) const {
  for (const std::size_t c : normal_) {
    const double length = std::hypot(sum[c], sum[c + 1], sum[c + 2]);
    if (!(length > 0) || !std::isfinite(length)) continue;
    for (std::size_t i = c; i < c + 3; ++i) sum[i] /= length;
  }
  pack_row(specs_, sum, row);
}

}  // namespace remaps::resample
