#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps::simplify {

/// Vertices by whole-numbered keys: lists of equal keys, first in, first out. Setting and leaving
/// take constant time; keys beyond the range are served at its ends.
class BucketQueue {
 public:
  /// @param least  the key of the lowest bucket
  void reset(std::size_t vertices, std::int32_t least) {
    least_ = least;
    entry_.assign(vertices, Entry{});
    bucket_.assign(kBuckets, Bucket{});
    lowest_ = kBuckets;
    size_ = 0;
  }
  bool empty() const { return size_ == 0; }
  bool contains(LocalIndex v) const { return entry_[v].bucket != kOut; }
  /// The lowest key. Requires !empty().
  std::int32_t top_key() {
    while (bucket_[lowest_].first == kNoIndex) ++lowest_;
    return least_ + static_cast<std::int32_t>(lowest_);
  }
  /// The vertex that has had the lowest key for longest.
  LocalIndex top() {
    top_key();
    return bucket_[lowest_].first;
  }
  /// The key that `key` counts as.
  std::int32_t clamped(std::int32_t key) const {
    return std::clamp(key, least_, least_ + static_cast<std::int32_t>(kBuckets) - 1);
  }

  /// Inserts v or changes its key.
  void set(LocalIndex v, std::int32_t key) {
    const auto b = static_cast<std::uint32_t>(clamped(key) - least_);
    Entry& entry = entry_[v];
    if (entry.bucket == b) return;
    if (entry.bucket != kOut) erase(v);
    Bucket& bucket = bucket_[b];
    entry = {bucket.last, kNoIndex, b};
    (bucket.last == kNoIndex ? bucket.first : entry_[bucket.last].after) = v;
    bucket.last = v;
    lowest_ = std::min(lowest_, b);
    ++size_;
  }
  void erase(LocalIndex v) {
    Entry& entry = entry_[v];
    if (entry.bucket == kOut) return;
    Bucket& bucket = bucket_[entry.bucket];
    (entry.before == kNoIndex ? bucket.first : entry_[entry.before].after) = entry.after;
    (entry.after == kNoIndex ? bucket.last : entry_[entry.after].before) = entry.before;
    entry.bucket = kOut;
    --size_;
  }

 private:
  static constexpr std::uint32_t kBuckets = 1024;
  static constexpr std::uint32_t kOut = kNoIndex;

  struct Entry {
    LocalIndex before = kNoIndex;
    LocalIndex after = kNoIndex;
    std::uint32_t bucket = kOut;
  };
  struct Bucket {
    LocalIndex first = kNoIndex;
    LocalIndex last = kNoIndex;
  };

  std::int32_t least_ = 0;
  std::uint32_t lowest_ = 0;
  std::size_t size_ = 0;
  std::vector<Entry> entry_;
  std::vector<Bucket> bucket_;
};

}  // namespace remaps::simplify
