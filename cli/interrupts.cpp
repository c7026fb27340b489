#include "interrupts.h"

#include <unistd.h>

#include <atomic>

#include "exit_codes.h"

namespace remaps::cli {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

// A signal handler has no other way to know what it should stop.
std::atomic<Progress*> job = nullptr;
static_assert(std::atomic<Progress*>::is_always_lock_free);

void cancel_job(int) {
  Progress* const progress = job.load();
  if (progress == nullptr || progress->cancelled()) _exit(static_cast<int>(ExitCode::kCancelled));
  progress->cancel();
}

}  // namespace

CancelOnSignal::CancelOnSignal(Progress& progress) {
  job = &progress;
  struct sigaction action {};
  action.sa_handler = cancel_job;
  action.sa_flags = SA_RESTART;  // reads and writes under way go on
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &action, nullptr);
  }
}

CancelOnSignal::~CancelOnSignal() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    sigaction(kSignals[i], &before_[i], nullptr);
  job = nullptr;
}

}  // namespace remaps::cli
