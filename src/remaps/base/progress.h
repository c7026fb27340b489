#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "remaps/base/errors.h"

namespace remaps {

/// Carries progress out of a long job and the wish to stop into it. One object a run; the core
/// never prints, it reports here. `cancel` may be called from a signal handler or another thread.
class Progress {
 public:
  /// Called with the name of the phase and the fraction done in it, 0 to 1. From one thread at a
  /// time.
  using Listener = std::function<void(std::string_view phase, double fraction)>;

  Progress() = default;
  explicit Progress(Listener listener) : listener_(std::move(listener)) {}

  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }

  /// @throws Cancelled  when cancel() was called
  void check() const {
    if (cancelled()) throw Cancelled();
  }

  /// Starts a phase. begin and advance are called by one thread at a time: the one
  /// that runs the job, or the one that commits its results in order.
  void begin(std::string_view phase) {
    phase_ = phase;
    advance(0);
  }
  /// Reports the fraction done of the present phase and checks for cancellation.
  void advance(double fraction) {
    check();
    if (listener_) listener_(phase_, fraction);
  }

 private:
  std::atomic<bool> cancelled_ = false;
  Listener listener_;
  std::string phase_;
};

}  // namespace remaps
