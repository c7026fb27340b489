#include <signal.h>

#include <chrono>
#include <thread>

#include "cli/run_binary.h"

namespace remaps {
namespace {

using namespace std::chrono_literals;

/// A job of a few seconds, in its middle: its temporary files are there.
class Interrupted : public CommandLine {
 protected:
  std::unique_ptr<RunningBinary> start() const {
    generate("in.ply", "300k");
    auto job = std::make_unique<RunningBinary>(
        std::vector<std::string>{"remesh", "in.ply", "out.ply", "--bundle", "out.remaps",
                                 "--report", "r.json"},
        directory());
    while (job->is_running() && names_here().size() < 2) std::this_thread::sleep_for(1ms);
    std::this_thread::sleep_for(300ms);
    EXPECT_TRUE(job->is_running());
    return job;
  }
};

TEST_F(Interrupted, ByCtrlCLeavesNothing) {
  const auto job = start();
  job->send(SIGINT);
  const Finished finished = job->wait();
  EXPECT_EQ(finished.exit_code, 130);
  EXPECT_EQ(finished.out, "");
  EXPECT_EQ(finished.err, "remaps: cancelled\n");
  EXPECT_EQ(names_here(), std::vector<std::string>{"in.ply"});
}

TEST_F(Interrupted, ByTerminateLeavesNothing) {
  const auto job = start();
  job->send(SIGTERM);
  EXPECT_EQ(job->wait().exit_code, 130);
  EXPECT_EQ(names_here(), std::vector<std::string>{"in.ply"});
}

TEST_F(Interrupted, TwiceEndsAtOnce) {
  const auto job = start();
  job->send(SIGINT);
  std::this_thread::sleep_for(1ms);
  job->send(SIGINT);
  const auto asked = std::chrono::steady_clock::now();
  EXPECT_EQ(job->wait().exit_code, 130);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, 2s);
  EXPECT_FALSE(std::filesystem::exists(directory() / "out.ply"));
}

TEST_F(Interrupted, ByKillLeavesNothingUnderFinalNames) {
  const auto job = start();
  job->send(SIGKILL);
  EXPECT_EQ(job->wait().exit_code, 128 + SIGKILL);
  for (const char* const name : {"out.ply", "out.remaps", "r.json"}) {
    EXPECT_FALSE(std::filesystem::exists(directory() / name)) << name;
  }
}

TEST_F(Interrupted, KeepsAnEarlierOutput) {
  make_file("out.ply", "precious");
  generate("in.ply", "300k");
  RunningBinary job({"remesh", "in.ply", "out.ply"}, directory());
  std::this_thread::sleep_for(500ms);
  job.send(SIGINT);
  EXPECT_EQ(job.wait().exit_code, 130);
  EXPECT_EQ(bytes_of(directory() / "out.ply"), "precious");
  EXPECT_EQ(names_here(), (std::vector<std::string>{"in.ply", "out.ply"}));
}

TEST_F(Interrupted, GenerateLeavesNothing) {
  RunningBinary job({"generate", "big.ply", "--vertices", "100M"}, directory());
  std::this_thread::sleep_for(200ms);
  job.send(SIGINT);
  EXPECT_EQ(job.wait().exit_code, 130);
  EXPECT_EQ(names_here(), std::vector<std::string>{});
}

}  // namespace
}  // namespace remaps
