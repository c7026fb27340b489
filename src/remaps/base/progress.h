#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"

namespace remaps {

/// A phase that is to come, and the time that it is expected to take: in any unit that all phases
/// of a plan share.
struct PlannedPhase {
  std::string name;
  double weight = 0;
};

/// A run at one moment: expected time of the phases that are over, of the present one as a whole,
/// and of those to come.
struct RunShares {
  double done = 0, present = 0, later = 0;
};

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

  /// Says what phases are to begin, in their order. May be called again as more is known: of an
  /// earlier plan stays what it has behind the last of these phases, or all of it if it has not
  /// that one. By the thread that calls begin.
  void plan(std::vector<PlannedPhase> phases) {
    planned_ = true;
    if (phases.empty()) return;
    const auto last = find(phases.back().name);
    const auto stays = last == to_come_.end() ? to_come_.begin() : last + 1;
    phases.insert(phases.end(), stays, to_come_.end());
    to_come_ = std::move(phases);
  }

  /// How far the run is by its plan; nothing without one. To be called by the listener.
  std::optional<RunShares> run() const {
    if (!planned_) return std::nullopt;
    RunShares shares{done_, present_, 0};
    for (const PlannedPhase& phase : to_come_) shares.later += phase.weight;
    return shares;
  }

  /// Starts a phase. begin and advance are called by one thread at a time: the one
  /// that runs the job, or the one that commits its results in order. A plan's phases before this
  /// one are left out.
  void begin(std::string_view phase) {
    if (phase != phase_) enter(phase);
    low_ = 0;
    high_ = 1;
    advance(0);
  }
  /// Reports the fraction done of the present phase, or of its present part, and checks for
  /// cancellation.
  void advance(double fraction) {
    check();
    if (listener_) listener_(phase_, low_ + fraction * (high_ - low_));
  }

 private:
  friend class ProgressPart;

  std::vector<PlannedPhase>::iterator find(std::string_view phase) {
    return std::find_if(to_come_.begin(), to_come_.end(),
                        [&](const PlannedPhase& p) { return p.name == phase; });
  }

  void enter(std::string_view phase) {
    phase_ = phase;
    done_ += std::exchange(present_, 0);
    const auto at = find(phase);
    if (at == to_come_.end()) return;
    present_ = at->weight;
    to_come_.erase(to_come_.begin(), at + 1);
  }

  std::atomic<bool> cancelled_ = false;
  Listener listener_;
  std::string phase_;
  double low_ = 0, high_ = 1;  // what 0 and 1 are in the phase
  bool planned_ = false;
  std::vector<PlannedPhase> to_come_;
  double done_ = 0, present_ = 0;
};

/// While it lives, what is reported is a part of the phase: 0 to 1 mean `from` to `to`. Parts nest.
class ProgressPart {
 public:
  /// @param progress  may be null
  ProgressPart(Progress* progress, double from, double to) : progress_(progress) {
    if (progress_ == nullptr) return;
    low_ = progress_->low_;
    high_ = progress_->high_;
    progress_->low_ = low_ + from * (high_ - low_);
    progress_->high_ = low_ + to * (high_ - low_);
  }
  ~ProgressPart() {
    if (progress_ == nullptr) return;
    progress_->low_ = low_;
    progress_->high_ = high_;
  }
  ProgressPart(const ProgressPart&) = delete;
  ProgressPart& operator=(const ProgressPart&) = delete;

 private:
  Progress* progress_;
  double low_ = 0, high_ = 1;
};

}  // namespace remaps
