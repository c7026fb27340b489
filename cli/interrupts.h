#pragma once

#include <signal.h>

#include <array>

#include "remaps/base/progress.h"

namespace remaps::cli {

/// While it lives, Ctrl-C and SIGTERM cancel a job, which then cleans up and throws Cancelled; the
/// second such signal ends the process at once with exit code 130. Signals that the process was
/// started to ignore (nohup, background jobs) stay ignored. At most one at a time.
class CancelOnSignal {
 public:
  explicit CancelOnSignal(Progress& progress);
  ~CancelOnSignal();
  CancelOnSignal(const CancelOnSignal&) = delete;
  CancelOnSignal& operator=(const CancelOnSignal&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

}  // namespace remaps::cli
