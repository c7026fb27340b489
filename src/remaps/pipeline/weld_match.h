#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/pipeline/weld_files.h"

/// The first half of welding: finds out where each vertex goes. Vertices are dealt out to buckets
/// by place, so that those that may be joined meet in one, and the buckets are looked at one by
/// one.
namespace remaps::pipeline {

/// What the stages of welding share.
struct WeldScratch {
  std::filesystem::path directory;
  std::uint64_t memory_bytes = 0;
  MemoryBudget* budget = nullptr;
};

/// Joins each vertex to the first one of exactly its position (-0 is 0). One that is not finite is
/// joined to none.
template <class Point>
class EqualMatcher {
 public:
  explicit EqualMatcher(const WeldScratch& scratch);

  /// Vertices come in the order of their numbers.
  void add(VertexId v, const Point& p);
  /// Tells of each vertex where it goes. `progress` gets fractions and may throw.
  void match(LinkBuckets<Point>& links, FunctionRef<void(double)> progress);

 private:
  struct Place {
    Point p;
    VertexId first;
  };
  void put(store::BucketFile& file, std::size_t bucket, VertexId& before, VertexId v,
           const Point& p);
  void match_bucket(const store::BucketFile& file, std::size_t bucket, LinkBuckets<Point>& links);

  WeldScratch scratch_;
  store::BucketFile file_;
  std::vector<VertexId> before_;  // the last one in each bucket
  // Places of one bucket, by hash. Those that find no room go to the other half of rest_, which is
  // looked at next.
  std::size_t most_places_ = 0;
  std::vector<Place> place_;
  std::vector<std::uint32_t> slot_;
  std::unique_ptr<store::BucketFile> rest_;
  std::size_t rest_half_ = 0;
  VertexId before_in_rest_ = 0;
};

/// Joins each vertex to the lowest-numbered one within a distance of it. One that is not finite is
/// joined to none.
template <class Point>
class NearMatcher {
 public:
  NearMatcher(const WeldScratch& scratch, double distance);

  void add(VertexId v, const Point& p);
  /// @throws BudgetError  one bucket does not fit the memory: the distance is far too large
  void match(LinkBuckets<Point>& links, FunctionRef<void(double)> progress);

 private:
  struct Candidate {
    std::uint64_t cell;  // hash
    VertexId v;
    Point p;
    bool home;  // its cell is in this bucket; others are there to be found by neighbours
  };
  Vec3 cell_of(const Point& p) const;
  void put(std::size_t bucket, VertexId v, const Point& p, bool home);
  void load(std::size_t bucket);
  void index_cells();
  VertexId lowest_near(const Candidate& c) const;

  WeldScratch scratch_;
  double distance_, side_;
  store::BucketFile file_;
  std::vector<VertexId> before_;
  std::vector<Candidate> candidate_;  // of one bucket, by cell and number
  std::vector<std::uint32_t> slot_;   // of the first one of a cell, by hash
};

}  // namespace remaps::pipeline
