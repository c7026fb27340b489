#include "remaps/store/row_join.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "remaps/store/row_spool.h"
#include "support/temp_files.h"

namespace remaps::store {
namespace {

struct Answer {
  std::uint32_t payload;
  std::vector<std::byte> row;

  friend bool operator==(const Answer&, const Answer&) = default;
};

class ListGather final : public RowJoin::Gather {
 public:
  void begin(std::uint64_t count) override {
    first_ = answers.size();
    answers.resize(first_ + static_cast<std::size_t>(count));
    largest = std::max(largest, count);
  }
  void take(std::size_t number, ByteSpan payload, ByteSpan row) override {
    Answer answer{0, {row.begin(), row.end()}};
    std::memcpy(&answer.payload, payload.data(), payload.size());
    answers.at(first_ + number).push_back(answer);
  }
  void end() override {}

  std::vector<std::vector<Answer>> answers;
  std::uint64_t largest = 0;

 private:
  std::size_t first_ = 0;
};

class RowJoinTest : public test::TempFiles {};

std::vector<std::byte> row_of(std::uint64_t number, std::size_t bytes) {
  std::vector<std::byte> row(bytes);
  for (std::size_t i = 0; i < bytes; ++i) {
    row[i] = static_cast<std::byte>((number * 2654435761u) >> (8 * (i % 5)));
  }
  return row;
}

TEST_F(RowJoinTest, GivesEveryAskerItsRowsInOrderWithAnyMemory) {
  for (const std::size_t width : {1u, 7u, 300u}) {
    for (const std::uint64_t count : {1u, 1023u, 1024u, 1025u, 20'000u}) {
      for (const std::uint64_t buffer : {std::uint64_t{1} << 12, std::uint64_t{1} << 22}) {
        SCOPED_TRACE(std::to_string(width) + " bytes, " + std::to_string(count) + ", buffer " +
                     std::to_string(buffer));
        MemoryBudget budget(64 << 20);
        std::mt19937_64 random(count + width);
        std::vector<std::vector<Answer>> expected(3000);
        RowJoin join("rows", directory(), {count, expected.size(), width, 4, width}, buffer,
                     budget);
        for (std::uint64_t asker = 0; asker < expected.size(); ++asker) {
          std::vector<std::uint64_t> rows;
          for (std::uint64_t i = random() % 5; i > 0; --i) rows.push_back(random() % count);
          std::sort(rows.begin(), rows.end());
          for (const std::uint64_t row : rows) {
            const auto payload = static_cast<std::uint32_t>(random());
            join.ask(row, asker, std::as_bytes(std::span(&payload, 1)));
            expected[asker].push_back({payload, row_of(row, width)});
          }
        }
        ListGather gather;
        const auto read = [&](std::uint64_t first, std::span<std::byte> out) {
          for (; !out.empty(); out = out.subspan(width)) {
            const auto row = row_of(first++, width);
            std::copy(row.begin(), row.end(), out.begin());
          }
          EXPECT_LE(first, count);
        };
        join.run(read, gather, buffer, [](double) {});
        EXPECT_TRUE(gather.answers == expected);
        if (buffer < 1 << 20 && width == 300) {
          EXPECT_LE(gather.largest, 1024u);
        }
      }
    }
  }
  EXPECT_EQ(entries_in(directory()), 0u);
}

TEST_F(RowJoinTest, RefusesARowThatIsNotThere) {
  MemoryBudget budget(64 << 20);
  RowJoin join("rows", directory(), {10, 10, 4, 0, 4}, 1 << 16, budget);
  EXPECT_NO_THROW(join.ask(9, 0, {}));
  EXPECT_THROW(join.ask(10, 0, {}), CorruptionError);
  EXPECT_EQ(join.asked(), 1u);
}

TEST_F(RowJoinTest, HoldsItsBuffersInTheBudget) {
  MemoryBudget budget(1 << 16);
  EXPECT_THROW(RowJoin("rows", directory(), {1u << 30, 10, 64, 0, 4}, 1 << 20, budget),
               BudgetError);
}

TEST_F(RowJoinTest, SpoolsRowsAndRefusesThoseBeyondTheLast) {
  RowSpool spool(directory() / "spool", 3);
  for (std::uint64_t i = 0; i < 100; ++i) spool.append(row_of(i, 3));
  EXPECT_EQ(spool.rows(), 100u);
  Bytes out(6);
  spool.read(98, out);
  EXPECT_EQ(Bytes(out.begin() + 3, out.end()), row_of(99, 3));
  EXPECT_THROW(spool.read(99, out), CorruptionError);
}

}  // namespace
}  // namespace remaps::store
