#include "remaps/formats/corner_splitter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace remaps {

CornerSplitter::CornerSplitter(const std::filesystem::path& target, std::uint64_t vertices,
                               std::size_t numbers)
    : vertices_(vertices), records_(target, sizeof(Link) + numbers * sizeof(float)) {}

std::uint64_t CornerSplitter::split(std::uint64_t v, std::span<const float> value) {
  Link link;
  const auto same = [&](const std::byte* record) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      float other = 0;
      std::memcpy(&other, record + sizeof link + i * sizeof other, sizeof other);
      if (!(std::fabs(value[i] - other) <= kSame)) return false;
    }
    return true;
  };
  const auto put = [&](std::uint64_t number, const Link& fresh) {
    std::byte* const record = records_.change(number);
    std::memcpy(record, &fresh, sizeof fresh);
    std::memcpy(record + sizeof fresh, value.data(), value.size_bytes());
  };
  for (std::uint64_t at = v;;) {
    const std::byte* const record = records_.at(at);
    std::memcpy(&link, record, sizeof link);
    if (link.taken == 0) {
      put(at, {v, 0, 1});
      return at;
    }
    if (same(record)) return at;
    if (link.next == 0) {
      link.next = ++copies_;
      std::memcpy(records_.change(at), &link, sizeof link);
      put(vertices_ + copies_ - 1, {v, 0, 1});
      return vertices_ + copies_ - 1;
    }
    at = vertices_ + link.next - 1;
  }
}

std::uint64_t CornerSplitter::read(std::uint64_t number, std::span<float> value) {
  const std::byte* const record = records_.at(number);
  Link link;
  std::memcpy(&link, record, sizeof link);
  std::memcpy(value.data(), record + sizeof link, value.size_bytes());
  return link.taken == 0 ? number : link.original;
}

}  // namespace remaps
