#include <sys/stat.h>
#include <unistd.h>

#include "cli/run_binary.h"

namespace remaps {
namespace {

TEST_F(CommandLine, PrintsItsVersion) {
  const Finished finished = run_well({"--version"});
  EXPECT_EQ(finished.out.find("remaps "), 0u);
  EXPECT_EQ(finished.err, "");
}

TEST_F(CommandLine, AloneShowsHelpAndFails) {
  const Finished finished = run({});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_EQ(finished.out, "");
  EXPECT_NE(finished.err.find("Usage: remaps"), std::string::npos);
}

TEST_F(CommandLine, HelpNamesVerbsAndExitCodes) {
  const Finished finished = run_well({"--help"});
  for (const char* const word : {"remesh", "parameterize", "resample", "verify", "measure", "info",
                                 "locate", "generate", "130 cancelled"}) {
    EXPECT_NE(finished.out.find(word), std::string::npos) << word;
  }
}

TEST_F(CommandLine, HelpOfEachVerbFitsItsLines) {
  for (const char* const verb :
       {"remesh", "parameterize", "resample", "verify", "measure", "info", "locate", "generate"}) {
    const Finished finished = run_well({verb, "--help"});
    EXPECT_NE(finished.out.find(std::string("Usage: remaps ") + verb), std::string::npos);
    std::istringstream lines(finished.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST_F(CommandLine, HelpShowsDefaults) {
  const Finished finished = run_well({"remesh", "--help"});
  for (const char* const text :
       {"--memory SIZE [256M]", "--level N [5]", "--base-vertices N [200]", "--samples N [1M]"}) {
    EXPECT_NE(finished.out.find(text), std::string::npos) << text;
  }
}

TEST_F(CommandLine, RefusesWrongUseWithALineAndAHint) {
  generate("in.ply", "500");
  expect_failure(2, {"frobnicate"}, {"frobnicate"});
  expect_failure(2, {"remesh"}, {"INPUT"});
  expect_failure(2, {"remesh", "in.ply"}, {"OUTPUT", "remaps remesh --help"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "more.ply"}, {"more.ply"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--lvl", "3"}, {"--lvl"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--level"}, {"--level"});
  expect_failure(2, {"parameterize", "in.ply", "x.remaps", "--level", "3"}, {"--level"});
  expect_failure(2, {"resample", "x.remaps"}, {"OUTPUT"});
  expect_failure(2, {"locate", directory().string()}, {"--vertex"});
  expect_failure(2, {"generate", "out.ply", "--base", "teapot"}, {"teapot", "torus"});
}

TEST_F(CommandLine, RefusesValuesOutOfRange) {
  generate("in.ply", "500");
  const auto expect_refused = [&](const std::string& option, const std::string& value) {
    expect_failure(2, {"remesh", "in.ply", "out.ply", option, value}, {option, value});
  };
  for (const char* const value : {"15", "-1", "5.5", "five"}) expect_refused("--level", value);
  for (const char* const value : {"3", "0", "-200", "1.5", "2x"}) {
    expect_refused("--base-vertices", value);
  }
  for (const char* const value : {"257", "-1", "two"}) expect_refused("--threads", value);
  for (const char* const value : {"0", "-256M", "256X", "M", "1e9999G", "16777216T", "1.5"}) {
    expect_refused("--memory", value);
  }
  for (const char* const value : {"0", "many"}) expect_refused("--samples", value);
  for (const char* const value : {"0", "180", "-30", "nan", "sharp"}) {
    expect_refused("--feature-angle", value);
  }
  expect_refused("--domain-buffer", "x");
  expect_refused("--map-buffer", "-3");
}

TEST_F(CommandLine, ChecksOutputsBeforeAnyWork) {
  generate("in.ply", "500");
  std::filesystem::create_directory(directory() / "dir.ply");
  std::filesystem::create_directory(directory() / "full");
  make_file("full/letter.txt", "dear diary");
  make_file("file.remaps", "no directory");

  expect_failure(2, {"remesh", "in.ply", "out.step"}, {"out.step", ".ply", ".glb"});
  expect_failure(2, {"remesh", "in.ply", "nowhere/out.ply"}, {"nowhere"});
  expect_failure(2, {"remesh", "in.ply", "dir.ply"}, {"directory"});
  expect_failure(2, {"remesh", "in.ply", "in.ply"}, {"input", "output"});
  expect_failure(2, {"remesh", "in.ply", "./in.ply"}, {"same file"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--report", "in.ply"}, {"report"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--report", "nowhere/r.json"}, {"nowhere"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--bundle", "full"}, {"full"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--bundle", "file.remaps"}, {"file.remaps"});
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--temp-dir", "nowhere"}, {"nowhere"});
  for (const char* weld : {"-1", "nan", "near"})
    expect_failure(2, {"remesh", "in.ply", "out.ply", "--weld", weld}, {"--weld", "0 or more"});
  expect_failure(2, {"generate", "nowhere/out.ply"}, {"nowhere"});
  EXPECT_EQ(bytes_of(directory() / "full/letter.txt"), "dear diary");

  std::filesystem::create_hard_link(directory() / "in.ply", directory() / "link.ply");
  expect_failure(2, {"remesh", "in.ply", "link.ply"}, {"same file"});
}

TEST_F(CommandLine, RefusesADirectoryThatCannotBeWrittenTo) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  generate("in.ply", "500");
  const std::filesystem::path closed = directory() / "closed";
  std::filesystem::create_directory(closed);
  chmod(closed.c_str(), 0500);
  expect_failure(2, {"remesh", "in.ply", "closed/out.ply"}, {"cannot be written to"});
  chmod(closed.c_str(), 0700);
}

TEST_F(CommandLine, InputsThatAreNotThereAreInputErrors) {
  expect_failure(3, {"remesh", "none.ply", "out.ply"}, {"none.ply"});
  expect_failure(3, {"parameterize", "none.ply", "out.remaps"}, {"none.ply"});
  expect_failure(3, {"resample", "none.remaps", "out.ply"}, {"none.remaps"});
  expect_failure(3, {"verify", "none.remaps"}, {"none.remaps"});
  expect_failure(3, {"locate", "none.remaps", "--vertex", "1"}, {"none.remaps"});
  expect_failure(3, {"measure", "none.ply", "none2.ply"}, {"none.ply"});
  expect_failure(3, {"info", "none.ply"}, {"none.ply"});
  std::filesystem::create_directory(directory() / "empty.remaps");
  expect_failure(3, {"verify", "empty.remaps"}, {"empty.remaps"});
  expect_failure(3, {"remesh", "empty.remaps", "out.ply"}, {"directory"});
}

TEST_F(CommandLine, TruncatedInputIsAnInputError) {
  const std::string whole = bytes_of(generate("whole.ply", "2000"));
  make_file("cut.ply", std::string_view(whole).substr(0, whole.size() / 2));
  for (const char* const verb : {"remesh", "parameterize"}) {
    expect_failure(3, {verb, "cut.ply", verb == std::string("remesh") ? "out.ply" : "out.remaps"},
                   {"cut.ply"});
  }
  expect_failure(3, {"info", "cut.ply"}, {"cut.ply"});
  expect_failure(3, {"measure", "whole.ply", "cut.ply"}, {"cut.ply"});
  EXPECT_EQ(names_here(), (std::vector<std::string>{"cut.ply", "whole.ply"}));
}

TEST_F(CommandLine, NonManifoldInputIsAGeometryError) {
  // Three triangles on one edge.
  make_file("fin.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  expect_failure(4, {"remesh", "fin.obj", "out.ply", "--strict"}, {"--strict"});
  EXPECT_EQ(names_here(), std::vector<std::string>{"fin.obj"});
}

TEST_F(CommandLine, TooLittleMemoryIsABudgetError) {
  generate("in.ply", "500");
  expect_failure(5, {"remesh", "in.ply", "out.ply", "--memory", "1M"}, {"1M"});
  EXPECT_EQ(names_here(), std::vector<std::string>{"in.ply"});
}

TEST_F(CommandLine, AFullStandardOutputIsAnError) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  generate("in.ply", "500");
  const std::string command = std::string(REMAPS_BINARY) + " info " +
                              (directory() / "in.ply").string() + " > /dev/full 2> /dev/null";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 5);
}

}  // namespace
}  // namespace remaps
