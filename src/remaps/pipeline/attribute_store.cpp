#include "remaps/pipeline/attribute_store.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/store/row_join.h"
#include "remaps/store/row_spool.h"

namespace remaps::pipeline {
namespace {

static_assert(sizeof(Triangle) == 3 * AttributeLayout::kCornerVertex);

/// Rows that are put together at a time, and the bytes that they may take.
constexpr std::uint64_t kMostChunk = 1 << 10;
constexpr std::size_t kChunkBytes = 256 << 10;

/// Adds the values of a pool up where they are used: at corners, where there is one, or at
/// vertices.
class PoolGather final : public store::RowJoin::Gather {
 public:
  PoolGather(const AttributeSpec& spec, store::RowSpool& rows)
      : spec_(spec), values_(spec.components.size()), rows_(rows) {}

  static std::size_t bytes_each(const AttributeSpec& spec) {
    return (spec.components.size() + 1) * sizeof(double) + row_bytes(spec);
  }

  void begin(std::uint64_t count) override {
    sum_.assign(static_cast<std::size_t>(count) * values_.size(), 0);
    uses_.assign(static_cast<std::size_t>(count), 0);
  }
  void take(std::size_t number, store::ByteSpan, store::ByteSpan row) override {
    unpack_row({&spec_, 1}, row, values_);
    for (std::size_t c = 0; c < values_.size(); ++c)
      sum_[number * values_.size() + c] += values_[c];
    ++uses_[number];
  }
  void end() override {
    const std::size_t bytes = row_bytes(spec_);
    out_.resize(uses_.size() * bytes);
    for (std::size_t i = 0; i < uses_.size(); ++i) {
      const auto sum = std::span(sum_).subspan(i * values_.size(), values_.size());
      double scale = 1 / double(std::max<std::uint64_t>(uses_[i], 1));
      if (spec_.kind == AttributeKind::normal && uses_[i] > 1) {
        double square = 0;
        for (const double value : sum) square += value * value;
        if (square > 0 && std::isfinite(square)) scale = 1 / std::sqrt(square);
      }
      for (double& value : sum) value *= scale;
      pack_row({&spec_, 1}, sum, std::span(out_).subspan(i * bytes, bytes));
    }
    rows_.append(out_);
  }

 private:
  const AttributeSpec& spec_;
  std::vector<double> values_;
  store::RowSpool& rows_;
  std::vector<double> sum_;
  std::vector<std::uint64_t> uses_;
  store::Bytes out_;
};

/// Stores the attributes of one kind of element.
class ElementStore {
 public:
  ElementStore(IndexedMeshReader& reader, const AttributeLayout& wanted, AttributePer per,
               const std::filesystem::path& temp_dir, const MemoryPlan& plan, MemoryBudget& budget,
               Progress& progress)
      : reader_(reader),
        layout_(wanted),
        per_(per),
        temp_dir_(temp_dir),
        plan_(plan),
        budget_(budget),
        progress_(progress) {}

  void run(AttributeFileWriter& file) {
    if (layout_.rows(per_) == 0) return;
    const std::vector<AttributeSpec> all = reader_.attributes();
    std::size_t channel = 0;
    if (per_ == AttributePer::corner) {
      columns_.push_back({{}, AttributeLayout::kCornerVertex, 0, spool_corners()});
    }
    for (std::size_t number = 0; number < all.size(); ++number) {
      const AttributeSpec& spec = all[number];
      if (spec.per != per_) continue;
      if (std::find(layout_.specs.begin(), layout_.specs.end(), spec) != layout_.specs.end()) {
        columns_.push_back({spec, row_bytes(spec), channel, nullptr});
        if (spec.pooled) columns_.back().pool = spool_pool(spec, number);
      }
      if (!spec.pooled) channel += spec.components.size();
    }
    std::size_t bytes = 0;
    for (const Column& column : columns_) bytes += column.bytes;
    chunk_rows_ = std::clamp<std::uint64_t>(kChunkBytes / bytes, 1, kMostChunk);
    const bool direct = std::any_of(columns_.begin(), columns_.end(),
                                    [](const Column& c) { return c.pool == nullptr; });
    if (direct) {
      reader_.read_attributes(per_, [&](std::span<const double> rows) {
        for (; !rows.empty(); rows = rows.subspan(channel)) add_row(rows.first(channel), file);
        progress_.advance(reader_.pass_fraction());
      });
    } else {
      while (added_ < elements()) add_row({}, file);
    }
    flush(file);
  }

 private:
  struct Column {
    AttributeSpec spec;
    std::size_t bytes;
    std::size_t channel;  // the first of its own, in a row of the reader
    std::unique_ptr<store::RowSpool> pool;
  };

  std::uint64_t elements() const {
    return layout_.rows(per_) * (per_ == AttributePer::corner ? 3 : 1);
  }

  /// The vertices of the corners.
  std::unique_ptr<store::RowSpool> spool_corners() {
    auto rows = std::make_unique<store::RowSpool>(temp_dir_ / "attribute-corners",
                                                  AttributeLayout::kCornerVertex);
    reader_.read_triangles([&](std::span<const Triangle> triangles) {
      rows->append(std::as_bytes(triangles));
      progress_.advance(0.2 * reader_.pass_fraction());
    });
    return rows;
  }

  /// The values of a pooled attribute in the order of elements.
  std::unique_ptr<store::RowSpool> spool_pool(const AttributeSpec& spec, std::size_t number) {
    const std::size_t bytes = row_bytes(spec);
    store::RowSpool pool(temp_dir_ / "attribute-pool", bytes);
    store::Bytes packed;
    reader_.read_pool(number, [&](std::span<const double> rows) {
      const std::size_t width = spec.components.size();
      packed.resize(rows.size() / width * bytes);
      for (std::size_t i = 0; i < rows.size() / width; ++i) {
        pack_row({&spec, 1}, rows.subspan(i * width, width),
                 std::span(packed).subspan(i * bytes, bytes));
      }
      pool.append(packed);
      progress_.advance(0.2 * reader_.pass_fraction());
    });
    store::RowJoin join("attribute-values", temp_dir_,
                        {pool.rows(), elements(), bytes, 0, PoolGather::bytes_each(spec)},
                        plan_.bucket_bytes / 2, budget_);
    std::uint64_t corner = 0;
    reader_.read_pool_uses(number, [&](std::span<const PoolUse> uses) {
      for (const PoolUse& use : uses) {
        const std::uint64_t asker = per_ == AttributePer::corner ? corner : use.vertex;
        ++corner;
        if (use.value == PoolUse::kNone) continue;
        if (asker >= elements()) throw CorruptionError("a file changed while it was read");
        join.ask(use.value, asker, {});
      }
      progress_.advance(0.2 + 0.3 * reader_.pass_fraction());
    });
    const std::string name = "attribute-" + std::to_string(number);
    auto rows = std::make_unique<store::RowSpool>(temp_dir_ / name, bytes);
    PoolGather gather(spec, *rows);
    join.run([&](std::uint64_t first, std::span<std::byte> out) { pool.read(first, out); }, gather,
             plan_.bucket_bytes, [&](double fraction) { progress_.advance(0.5 + 0.5 * fraction); });
    return rows;
  }

  void add_row(std::span<const double> row, AttributeFileWriter& file) {
    if (added_ == elements()) throw CorruptionError("a file changed while it was read");
    if (added_ % chunk_rows_ == 0) load_pools();
    for (const Column& column : columns_) {
      const std::size_t at = chunk_.size();
      chunk_.resize(at + column.bytes);
      if (column.pool != nullptr) {
        const auto from = loaded_[static_cast<std::size_t>(&column - columns_.data())].begin() +
                          static_cast<std::ptrdiff_t>(added_ % chunk_rows_ * column.bytes);
        std::copy_n(from, column.bytes, chunk_.begin() + static_cast<std::ptrdiff_t>(at));
      } else {
        pack_row({&column.spec, 1}, row.subspan(column.channel, column.spec.components.size()),
                 std::span(chunk_).subspan(at));
      }
    }
    ++added_;
    // Three corners are one row of the file.
    if (added_ % (3 * chunk_rows_) == 0) flush(file);
  }

  void load_pools() {
    const std::uint64_t count = std::min(chunk_rows_, elements() - added_);
    loaded_.resize(columns_.size());
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].pool == nullptr) continue;
      loaded_[c].resize(static_cast<std::size_t>(count) * columns_[c].bytes);
      columns_[c].pool->read(added_, loaded_[c]);
    }
  }

  void flush(AttributeFileWriter& file) {
    if (!chunk_.empty()) file.add(per_, chunk_);
    chunk_.clear();
  }

  IndexedMeshReader& reader_;
  const AttributeLayout& layout_;
  AttributePer per_;
  const std::filesystem::path& temp_dir_;
  const MemoryPlan& plan_;
  MemoryBudget& budget_;
  Progress& progress_;
  std::vector<Column> columns_;
  std::vector<store::Bytes> loaded_;  // (columns) values of pools
  store::Bytes chunk_;
  std::uint64_t chunk_rows_ = 1;
  std::uint64_t added_ = 0;
};

}  // namespace

void store_attributes(IndexedMeshReader& reader, const AttributeLayout& wanted,
                      const std::filesystem::path& path, const std::filesystem::path& temp_dir,
                      const MemoryPlan& plan, MemoryBudget& budget, Progress& progress) {
  AttributeFileWriter file(path, wanted);
  unsigned part = 0;
  for (const AttributePer per : {AttributePer::vertex, AttributePer::face, AttributePer::corner}) {
    const ProgressPart progress_part(&progress, part / 3.0, (part + 1) / 3.0);
    ++part;
    ElementStore(reader, wanted, per, temp_dir, plan, budget, progress).run(file);
  }
  file.seal();
}

void store_copies(const store::RowSpool& originals, std::uint64_t copies,
                  const std::filesystem::path& path) {
  VertexCopiesWriter file(path);
  std::vector<VertexId> chunk;
  for (std::uint64_t first = 0; first < copies; first += chunk.size()) {
    chunk.resize(static_cast<std::size_t>(std::min(kMostChunk, copies - first)));
    originals.read(first, std::as_writable_bytes(std::span(chunk)));
    file.add(chunk);
  }
  file.seal();
}

}  // namespace remaps::pipeline
