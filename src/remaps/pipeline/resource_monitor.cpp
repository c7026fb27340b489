#include "remaps/pipeline/resource_monitor.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "remaps/store/disk_usage.h"

namespace remaps::pipeline {
namespace {

constexpr std::size_t kLongestTrace = 512;

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::uint64_t resident_bytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  unsigned long long total = 0;
  unsigned long long resident = 0;
  const bool read = std::fscanf(file, "%llu %llu", &total, &resident) == 2;
  std::fclose(file);
  return read ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

ResourceMonitor::ResourceMonitor()
    : start_(std::chrono::steady_clock::now()),
      cpu_at_start_(cpu_seconds()),
      io_at_start_(store::io_counts()),
      thread_([this] { watch(); }) {
  store::restart_disk_peak();
}

ResourceMonitor::~ResourceMonitor() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_all();
  thread_.join();
}

double ResourceMonitor::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void ResourceMonitor::watch() {
  auto interval = std::chrono::milliseconds(20);
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    trace_.push_back({seconds(), resident_bytes()});
    if (trace_.size() >= kLongestTrace) {
      for (std::size_t i = 0; 2 * i < trace_.size(); ++i) trace_[i] = trace_[2 * i];
      trace_.resize((trace_.size() + 1) / 2);
      interval *= 2;
    }
    stop_.wait_for(lock, interval, [this] { return stopping_; });
  }
}

namespace {

/// Largest resident memory. ru_maxrss has that of the parent as well, if this process was forked
/// from a large one (a Python script, say); the kernel's other count begins with the program.
std::uint64_t peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * 1024;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

void ResourceMonitor::finish(Report& report) {
  report.peak_rss_bytes = peak_resident_bytes();
  report.cpu_seconds = cpu_seconds() - cpu_at_start_;
  report.seconds_total = seconds();
  const store::IoCounts io = store::io_counts();
  report.bytes_read += io.read - io_at_start_.read;
  report.bytes_written += io.written - io_at_start_.written;
  report.peak_temp_bytes = store::disk_usage().peak;
  const std::scoped_lock lock(mutex_);
  report.memory_trace = trace_;
  report.memory_trace.push_back({report.seconds_total, resident_bytes()});
}

}  // namespace remaps::pipeline
