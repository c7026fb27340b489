#pragma once

#include <algorithm>
#include <optional>

#include "remaps/base/progress.h"

namespace remaps {

/// Seconds left; nothing where there is not enough to tell from.
struct TimeLeft {
  std::optional<double> phase, run;
};

/// Estimates the time left. A phase is as fast as it has been, and at its beginning as its weight
/// says; phases to come are as fast, for their weights, as the run has been.
///
/// @param fraction       of the present phase, 0 to 1
/// @param phase_seconds  since the phase began
/// @param total_seconds  since the run began
/// @param shares         of the run; nothing: only the phase is told of
inline TimeLeft time_left(double fraction, double phase_seconds, double total_seconds,
                          const std::optional<RunShares>& shares) {
  constexpr double kLeastFraction = 0.01, kLeastSeconds = 1;
  /// From this fraction on a phase's own speed is all that counts.
  constexpr double kTrusted = 0.25;
  TimeLeft left;
  const bool has_speed = fraction > kLeastFraction && phase_seconds >= kLeastSeconds;
  if (has_speed) left.phase = phase_seconds * (1 - fraction) / fraction;
  if (!shares) return left;

  const double before = total_seconds - phase_seconds;
  if (before >= kLeastSeconds && shares->done > 0 && shares->present > 0) {
    const double whole = shares->present * before / shares->done;
    const double by_weight =
        fraction > 0 ? whole * (1 - fraction) : std::max(0.0, whole - phase_seconds);
    const double trust = has_speed ? std::min(1.0, fraction / kTrusted) : 0.0;
    left.phase = trust * left.phase.value_or(0) + (1 - trust) * by_weight;
  }
  const double weight = shares->done + (has_speed ? fraction * shares->present : 0);
  const double spent = has_speed ? total_seconds : before;
  if (left.phase && weight > 0 && spent >= kLeastSeconds) {
    left.run = *left.phase + shares->later * spent / weight;
  }
  return left;
}

}  // namespace remaps
