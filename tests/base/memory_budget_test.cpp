#include "remaps/base/memory_budget.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace remaps {
namespace {

TEST(MemoryBudget, GivesBackWhatAReservationHeld) {
  MemoryBudget budget(1000);
  {
    const Reservation a = budget.reserve(600, "a");
    EXPECT_EQ(a.bytes(), 600u);
    EXPECT_EQ(budget.available(), 400u);
    const Reservation b = budget.reserve(400, "b");
    EXPECT_EQ(budget.available(), 0u);
  }
  EXPECT_EQ(budget.available(), 1000u);
  EXPECT_EQ(budget.total(), 1000u);
}

TEST(MemoryBudget, RefusesOneByteTooManyAndKeepsNothingOfIt) {
  MemoryBudget budget(std::uint64_t{8} << 20);
  const Reservation held = budget.reserve(std::uint64_t{5} << 20, "held");
  try {
    budget.reserve((std::uint64_t{3} << 20) + 1, "the pile");
    FAIL() << "was given";
  } catch (const BudgetError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("the pile"), std::string::npos) << message;
    EXPECT_NE(message.find("--memory 9M"), std::string::npos) << message;
  }
  EXPECT_EQ(budget.available(), std::uint64_t{3} << 20);
  EXPECT_NO_THROW(budget.reserve(std::uint64_t{3} << 20, "just fits"));
}

TEST(MemoryBudget, MovesAReservationWithoutCountingItTwice) {
  MemoryBudget budget(100);
  Reservation a = budget.reserve(60, "a");
  Reservation b = std::move(a);
  EXPECT_EQ(budget.available(), 40u);
  Reservation c = budget.reserve(10, "c");
  c = std::move(b);
  EXPECT_EQ(c.bytes(), 60u);
  { const Reservation gone = std::move(c); }
  b = Reservation();
  EXPECT_EQ(budget.available(), 100u);
}

TEST(MemoryBudget, NeverGivesMoreThanItHasToManyThreads) {
  MemoryBudget budget(64);
  std::vector<std::thread> threads;
  std::atomic<int> given = 0;
  std::atomic<int> most = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) {
        try {
          const Reservation r = budget.reserve(24, "share");
          const int now = ++given;
          if (now > most) most = now;
          --given;
        } catch (const BudgetError&) {
          continue;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(most, 2);
  EXPECT_GE(most, 1);
  EXPECT_EQ(budget.available(), 64u);
}

}  // namespace
}  // namespace remaps
