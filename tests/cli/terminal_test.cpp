#include "cli/run_binary.h"

namespace remaps {
namespace {

TEST_F(CommandLine, DrawsOneLineInATerminalAndWipesIt) {
  const Finished finished =
      run_in_terminal({"generate", "a.ply", "--vertices", "3M", "--threads", "1"}, directory(), 72);
  EXPECT_EQ(finished.exit_code, 0);
  const std::size_t last_wipe = finished.out.rfind("\r\x1b[K");
  ASSERT_NE(last_wipe, std::string::npos);
  EXPECT_NE(finished.out.find(" %  0:0"), std::string::npos) << finished.out;
  // All before the last wipe is one line, redrawn; each state fits the terminal.
  const std::string bar = finished.out.substr(0, last_wipe);
  EXPECT_EQ(bar.find('\n'), std::string::npos);
  std::istringstream states(bar);
  int drawn = 0;
  for (std::string state; std::getline(states, state, '\r');) {
    if (state.ends_with("\x1b[K")) state.resize(state.size() - 3);
    EXPECT_LT(state.size(), 72u) << state;
    ++drawn;
  }
  EXPECT_GT(drawn, 2);
  EXPECT_EQ(finished.out.substr(last_wipe + 4).find("a.ply: "), 0u) << finished.out;
}

TEST_F(CommandLine, QuietDrawsNothingInATerminal) {
  const Finished finished =
      run_in_terminal({"generate", "a.ply", "--vertices", "1M", "--quiet"}, directory(), 80);
  EXPECT_EQ(finished.exit_code, 0);
  EXPECT_EQ(finished.out, "");
}

TEST_F(CommandLine, DrawsWithinAVeryNarrowTerminal) {
  const Finished finished =
      run_in_terminal({"generate", "a.ply", "--vertices", "2M", "--threads", "1"}, directory(), 12);
  EXPECT_EQ(finished.exit_code, 0);
  const std::string bar = finished.out.substr(0, finished.out.rfind("\r\x1b[K"));
  EXPECT_EQ(bar.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace remaps
