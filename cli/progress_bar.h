#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "interrupts.h"
#include "remaps/base/progress.h"

namespace remaps::cli {

/// What the bar shows at one moment.
struct ProgressView {
  std::string phase;
  double fraction = 0;                             // of the phase, 0 to 1
  double phase_seconds = 0;                        // since the phase began
  double total_seconds = 0;                        // since the job began
  std::optional<RunShares> shares = std::nullopt;  // of the job, if it has a plan
  bool stopping = false;
};

/// One line of at most `columns` characters, without control characters:
/// "sweep 2  ███████▌       47 %  0:12, 0:14 left; in all 61 %, 0:41 left". Of a job without a plan
/// it ends "; 1:03 in all", the time since the job began.
std::string progress_line(const ProgressView& view, std::size_t columns, bool utf8);

/// Shows a job's progress on standard error, and lets Ctrl-C stop the job.
///
/// On a terminal one line is redrawn 10 times a second and wiped at the end. Elsewhere a line
/// follows each phase that took some seconds. Quiet: nothing at all.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// To be handed to the job.
  Progress& progress() { return progress_; }

 private:
  using Clock = std::chrono::steady_clock;
  enum class Mode { kQuiet, kLog, kDraw };

  void update(std::string_view phase, double fraction);
  void log_phase() const;
  void draw_until_stopped();
  void draw(std::unique_lock<std::mutex>& lock);

  const Mode mode_;
  const bool utf8_;
  const Clock::time_point start_ = Clock::now();
  std::mutex mutex_;
  std::condition_variable stop_;
  std::string phase_;
  double fraction_ = 0;
  std::optional<RunShares> shares_;
  Clock::time_point phase_start_ = start_;
  bool stopping_ = false;
  bool drawn_ = false;
  Progress progress_;
  CancelOnSignal cancel_on_signal_{progress_};
  std::thread painter_;
};

}  // namespace remaps::cli
