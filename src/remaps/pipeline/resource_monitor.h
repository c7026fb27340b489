#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "remaps/pipeline/report.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {

/// Watches the process while a run lasts: wall and CPU time, bytes through files, resident memory
/// over time. Samples ever more rarely, so that the trace keeps between 128 and 512 entries however
/// long the run.
class ResourceMonitor {
 public:
  ResourceMonitor();
  ~ResourceMonitor();
  ResourceMonitor(const ResourceMonitor&) = delete;
  ResourceMonitor& operator=(const ResourceMonitor&) = delete;

  double seconds() const;
  /// Fills total time, cpu_seconds, peak_rss_bytes, io and memory_trace.
  void finish(Report& report);

 private:
  void watch();

  std::chrono::steady_clock::time_point start_;
  double cpu_at_start_;
  store::IoCounts io_at_start_;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopping_ = false;
  std::vector<Report::MemorySample> trace_;
  std::thread thread_;
};

}  // namespace remaps::pipeline
