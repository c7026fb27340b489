#include "progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "number_text.h"
#include "remaps/base/time_left.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

constexpr std::size_t kPhaseColumns = 12;
constexpr std::size_t kLongestBar = 40, kShortestBar = 8;
constexpr std::size_t kTextColumns = 52;  // of percentage and times, beside the bar
constexpr double kLeastLoggedSeconds = 5;
constexpr auto kRedraw = std::chrono::milliseconds(100);

bool is_drawable_terminal() {
  const char* const term = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
}

bool is_utf8_locale() {
  for (const char* const name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* const value = std::getenv(name);
    if (value == nullptr || *value == '\0') continue;
    const std::string_view locale = value;
    for (const std::string_view utf8 : {"UTF-8", "utf8", "utf-8", "UTF8"}) {
      if (locale.find(utf8) != std::string_view::npos) return true;
    }
    return false;
  }
  return false;
}

std::size_t terminal_columns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

std::string bar_text(double fraction, std::size_t columns, bool utf8) {
  static constexpr const char* kEighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  std::string bar;
  const auto eighths = static_cast<std::size_t>(fraction * static_cast<double>(8 * columns));
  std::size_t filled = eighths / 8;
  for (std::size_t i = 0; i < filled; ++i) bar += utf8 ? "█" : "#";
  if (utf8 && eighths % 8 != 0) {
    bar += kEighths[eighths % 8];
    ++filled;
  }
  for (std::size_t i = filled; i < columns; ++i) bar += utf8 ? "░" : ".";
  return bar;
}

/// Elapsed and left in the phase; then percentage and time left of the whole job, or without a plan
/// the time since it began if that was another phase.
std::string times_text(const ProgressView& view) {
  std::string text = clock_text(view.phase_seconds);
  if (view.stopping) return text + ", stopping";
  const TimeLeft left =
      time_left(view.fraction, view.phase_seconds, view.total_seconds, view.shares);
  // Half a second more: what is nearly over has a second left, not none.
  if (left.phase && view.fraction < 1)
    text += fmt::format(", {} left", clock_text(*left.phase + 0.5));
  if (left.run) {
    text += fmt::format("; in all {:.0f} %, {} left",
                        std::floor(100 * view.total_seconds / (view.total_seconds + *left.run)),
                        clock_text(*left.run + 0.5));
  } else if (view.total_seconds > view.phase_seconds + 1) {
    text += fmt::format("; {} in all", clock_text(view.total_seconds));
  }
  return text;
}

}  // namespace

std::string progress_line(const ProgressView& view, std::size_t columns, bool utf8) {
  const double fraction = std::clamp(std::isfinite(view.fraction) ? view.fraction : 0, 0.0, 1.0);
  const std::string head = fmt::format("{:<{}}", view.phase, kPhaseColumns);
  const std::string tail =
      fmt::format("{:3.0f} %  {}", std::floor(fraction * 100), times_text(view));
  const std::size_t text = head.size() + tail.size() + 3;
  if (columns >= text + kShortestBar) {
    // The bar keeps its length while the times beside it come and go.
    const std::size_t room = std::max<std::size_t>(columns - std::min(columns, text), kShortestBar);
    const std::size_t wanted =
        columns > head.size() + kTextColumns ? columns - head.size() - kTextColumns : kShortestBar;
    return fmt::format("{}  {} {}", head,
                       bar_text(fraction, std::min({room, wanted, kLongestBar}), utf8), tail);
  }
  return fmt::format("{} {}", view.phase, tail).substr(0, columns);
}

ProgressBar::ProgressBar(bool quiet)
    : mode_(quiet                    ? Mode::kQuiet
            : is_drawable_terminal() ? Mode::kDraw
                                     : Mode::kLog),
      utf8_(is_utf8_locale()),
      progress_([this](std::string_view phase, double fraction) { update(phase, fraction); }) {
  if (mode_ == Mode::kDraw) painter_ = std::thread([this] { draw_until_stopped(); });
}

ProgressBar::~ProgressBar() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (painter_.joinable()) painter_.join();
  if (!progress_.cancelled()) log_phase();
}

void ProgressBar::update(std::string_view phase, double fraction) {
  if (mode_ == Mode::kQuiet) return;
  const std::lock_guard lock(mutex_);
  fraction_ = fraction;
  shares_ = progress_.run();
  if (phase == phase_) return;
  log_phase();
  phase_ = phase;
  phase_start_ = Clock::now();
}

void ProgressBar::log_phase() const {
  const double seconds = std::chrono::duration<double>(Clock::now() - phase_start_).count();
  if (mode_ != Mode::kLog || phase_.empty() || seconds < kLeastLoggedSeconds) return;
  log_line(fmt::format("{}: {}", phase_, seconds_text(seconds)));
}

void ProgressBar::draw_until_stopped() {
  std::unique_lock lock(mutex_);
  while (!stop_.wait_for(lock, kRedraw, [this] { return stopping_; })) {
    if (!phase_.empty()) draw(lock);
  }
  if (drawn_) fmt::print(stderr, "\r\x1b[K");
}

void ProgressBar::draw(std::unique_lock<std::mutex>& lock) {
  const Clock::time_point now = Clock::now();
  const ProgressView view{phase_,
                          fraction_,
                          std::chrono::duration<double>(now - phase_start_).count(),
                          std::chrono::duration<double>(now - start_).count(),
                          shares_,
                          progress_.cancelled()};
  drawn_ = true;
  lock.unlock();  // a slow terminal must not hold up the job
  // One column stays free: writing the last one wraps on some terminals.
  const std::string line =
      fmt::format("\r{}\x1b[K", progress_line(view, terminal_columns() - 1, utf8_));
  std::fwrite(line.data(), 1, line.size(), stderr);
  lock.lock();
}

}  // namespace remaps::cli
