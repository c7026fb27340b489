#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "remaps/base/errors.h"

namespace remaps {

class MemoryBudget;

/// A share of the budget, given back when it goes. Move-only.
class Reservation {
 public:
  Reservation() = default;
  Reservation(Reservation&& other) noexcept
      : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Reservation& operator=(Reservation&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  Reservation(const Reservation&) = delete;
  Reservation& operator=(const Reservation&) = delete;
  inline ~Reservation();

  std::uint64_t bytes() const { return bytes_; }

 private:
  friend class MemoryBudget;
  Reservation(MemoryBudget* budget, std::uint64_t bytes) : budget_(budget), bytes_(bytes) {}

  MemoryBudget* budget_ = nullptr;
  std::uint64_t bytes_ = 0;
};

/// The memory that one run may use. Every buffer that grows with the input or with the options
/// reserves its size here before it is allocated. Thread-safe.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t bytes) : total_(bytes) {}

  /// @throws BudgetError  less than `bytes` are left; says for what, and how much the run would
  /// have needed
  Reservation reserve(std::uint64_t bytes, std::string_view what) {
    const std::uint64_t before = used_.fetch_add(bytes);
    if (before + bytes > total_) {
      used_.fetch_sub(bytes);
      throw BudgetError(std::string(what) + " needs " + std::to_string(bytes >> 20) +
                        " MiB but only " + std::to_string((total_ - before) >> 20) +
                        " MiB of the budget of " + std::to_string(total_ >> 20) +
                        " MiB are left; --memory " + std::to_string(((before + bytes) >> 20) + 1) +
                        "M would do for this step");
    }
    return {this, bytes};
  }

  std::uint64_t total() const { return total_; }
  std::uint64_t available() const {
    const std::uint64_t used = used_.load();
    return used < total_ ? total_ - used : 0;
  }

 private:
  friend class Reservation;
  std::uint64_t total_;
  std::atomic<std::uint64_t> used_ = 0;
};

inline Reservation::~Reservation() {
  if (budget_ != nullptr) budget_->used_.fetch_sub(bytes_);
}

}  // namespace remaps
