#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "formats/mesh_files.h"

namespace remaps {

/// What a run of the binary left.
struct Finished {
  int exit_code = -1;  // 128 + number of the signal that killed it
  std::string out, err;
};

/// The binary under test, running in the background with its output going to files.
class RunningBinary {
 public:
  /// @param directory  its working directory; also holds what it prints
  RunningBinary(const std::vector<std::string>& arguments, const std::filesystem::path& directory);
  ~RunningBinary();  // kills it if wait was not called
  RunningBinary(const RunningBinary&) = delete;
  RunningBinary& operator=(const RunningBinary&) = delete;

  void send(int signal) const;
  /// False once it has ended.
  bool is_running() const;
  Finished wait();

 private:
  pid_t child_ = -1;
  std::filesystem::path out_, err_;
};

/// Runs the binary with standard input, output and error in a terminal of so many columns.
/// @return  exit code, and in `out` all that the terminal received
Finished run_in_terminal(const std::vector<std::string>& arguments,
                         const std::filesystem::path& directory, unsigned short columns);

/// Tests that run the binary, in a directory of their own.
class CommandLine : public MeshFiles {
 protected:
  Finished run(const std::vector<std::string>& arguments) const {
    return RunningBinary(arguments, directory()).wait();
  }
  /// Runs and expects success.
  Finished run_well(const std::vector<std::string>& arguments) const;
  /// Expects an exit code and one line of error that says all of the given things; usage errors
  /// have a hint below.
  void expect_failure(int exit_code, const std::vector<std::string>& arguments,
                      std::initializer_list<std::string_view> says = {}) const;
  /// A mesh of about so many vertices.
  std::filesystem::path generate(const std::string& name, const std::string& vertices,
                                 const std::vector<std::string>& more = {}) const;
  /// Names of all files and directories there, hidden ones included, sorted.
  std::vector<std::string> names_here() const;
};

}  // namespace remaps
