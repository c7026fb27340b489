#include "remaps/pipeline/weld_attributes.h"

#include <algorithm>

#include "remaps/base/errors.h"

namespace remaps::pipeline {
namespace {

constexpr std::size_t kChunk = 8192;

/// The numbers of a file one after the other.
class NumberStream {
 public:
  explicit NumberStream(NumberFile& file) : file_(file) {}

  std::uint64_t next() {
    if (at_ == chunk_.size()) {
      const std::uint64_t left = file_.size() - first_;
      if (left == 0) throw CorruptionError("a file changed while it was read");
      chunk_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kChunk, left)));
      file_.read(first_, chunk_);
      first_ += chunk_.size();
      at_ = 0;
    }
    return chunk_[at_++];
  }

 private:
  NumberFile& file_;
  std::vector<std::uint64_t> chunk_;
  std::size_t at_ = 0;
  std::uint64_t first_ = 0;
};

}  // namespace

std::vector<AttributeSpec> WeldedAttributes::attributes() {
  specs_ = source_.attributes();
  std::vector<AttributeSpec> welded = specs_;
  for (AttributeSpec& spec : welded) {
    if (!changes(spec)) continue;
    spec.pooled = true;
    if (spec.kind == AttributeKind::uv) spec.per = AttributePer::corner;
  }
  return welded;
}

void WeldedAttributes::read_attributes(AttributePer per, AttributeSink sink) {
  if (per == AttributePer::vertex) {
    read_first_rows(sink);
  } else {
    source_.read_attributes(per, sink);
  }
}

/// A vertex is the first of those that became one if its number is new: they rise in the order of
/// first vertices.
void WeldedAttributes::read_first_rows(AttributeSink sink) {
  std::vector<std::size_t> kept;  // channels
  std::size_t width = 0;
  for (const AttributeSpec& spec : specs_) {
    if (spec.per != AttributePer::vertex || spec.pooled) continue;
    for (std::size_t i = 0; i < spec.components.size(); ++i, ++width) {
      if (!changes(spec)) kept.push_back(width);
    }
  }
  if (kept.empty()) return;
  NumberStream number(numbers_);
  std::uint64_t firsts = 0;
  std::vector<double> rows;
  source_.read_attributes(AttributePer::vertex, [&](std::span<const double> chunk) {
    rows.clear();
    for (; !chunk.empty(); chunk = chunk.subspan(width)) {
      if (number.next() != firsts) continue;
      ++firsts;
      for (const std::size_t channel : kept) rows.push_back(chunk[channel]);
    }
    if (!rows.empty()) sink(rows);
  });
}

void WeldedAttributes::read_pool(std::size_t number, AttributeSink sink) {
  const AttributeSpec& wanted = specs_.at(number);
  if (!changes(wanted)) {
    source_.read_pool(number, sink);
    return;
  }
  std::size_t width = 0, first = 0;
  for (const AttributeSpec& spec : specs_) {
    if (&spec == &wanted) first = width;
    if (spec.per == AttributePer::vertex && !spec.pooled) width += spec.components.size();
  }
  std::vector<double> values;
  source_.read_attributes(AttributePer::vertex, [&](std::span<const double> chunk) {
    values.clear();
    for (; !chunk.empty(); chunk = chunk.subspan(width)) {
      const auto own = chunk.subspan(first, wanted.components.size());
      values.insert(values.end(), own.begin(), own.end());
    }
    sink(values);
  });
}

void WeldedAttributes::read_pool_uses(std::size_t number, PoolUseSink sink) {
  NumberStream corner(corners_);
  std::vector<PoolUse> uses;
  if (!changes(specs_.at(number))) {
    source_.read_pool_uses(number, [&](std::span<const PoolUse> chunk) {
      uses.assign(chunk.begin(), chunk.end());
      for (PoolUse& use : uses) use.vertex = corner.next();
      sink(uses);
    });
    return;
  }
  source_.read_triangles([&](std::span<const Triangle> triangles) {
    uses.clear();
    for (const Triangle& t : triangles) {
      for (const VertexId v : t) uses.push_back({corner.next(), v});
    }
    sink(uses);
  });
}

}  // namespace remaps::pipeline
