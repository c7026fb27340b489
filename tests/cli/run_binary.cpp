#include "cli/run_binary.h"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>

namespace remaps {
namespace {

std::string read_all(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

int exit_code_of(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int wait_for(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return exit_code_of(status);
}

/// Becomes the binary; only calls what is allowed between fork and exec.
[[noreturn]] void become_binary(char* const* arguments, const char* directory) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) signal(number, SIG_DFL);
  if (chdir(directory) == 0) execv(REMAPS_BINARY, arguments);
  _exit(127);
}

/// argv, which points into `arguments`.
std::vector<char*> argument_pointers(std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> with_name(const std::vector<std::string>& arguments) {
  std::vector<std::string> all{"remaps"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return all;
}

}  // namespace

RunningBinary::RunningBinary(const std::vector<std::string>& arguments,
                             const std::filesystem::path& directory) {
  static std::atomic<int> runs = 0;
  const std::string stem = "remaps_run_" + std::to_string(getpid()) + "_" + std::to_string(++runs);
  out_ = std::filesystem::path(testing::TempDir()) / (stem + ".out");
  err_ = std::filesystem::path(testing::TempDir()) / (stem + ".err");
  std::vector<std::string> all = with_name(arguments);
  const std::vector<char*> pointers = argument_pointers(all);
  child_ = fork();
  if (child_ != 0) return;
  constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
  const int in = open("/dev/null", O_RDONLY);
  const int out = open(out_.c_str(), kCreate, 0600);
  const int err = open(err_.c_str(), kCreate, 0600);
  if (dup2(in, 0) < 0 || dup2(out, 1) < 0 || dup2(err, 2) < 0) _exit(127);
  become_binary(pointers.data(), directory.c_str());
}

RunningBinary::~RunningBinary() {
  if (child_ > 0) {
    kill(child_, SIGKILL);
    wait_for(child_);
  }
  std::filesystem::remove(out_);
  std::filesystem::remove(err_);
}

void RunningBinary::send(int signal) const {
  ASSERT_EQ(kill(child_, signal), 0);
}

bool RunningBinary::is_running() const {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == 0;
}

Finished RunningBinary::wait() {
  Finished finished;
  finished.exit_code = wait_for(std::exchange(child_, -1));
  finished.out = read_all(out_);
  finished.err = read_all(err_);
  return finished;
}

Finished run_in_terminal(const std::vector<std::string>& arguments,
                         const std::filesystem::path& directory, unsigned short columns) {
  std::vector<std::string> all = with_name(arguments);
  const std::vector<char*> pointers = argument_pointers(all);
  winsize size{};
  size.ws_col = columns;
  size.ws_row = 24;
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
  if (child == 0) {
    setenv("TERM", "xterm", 1);
    setenv("LC_ALL", "C", 1);
    become_binary(pointers.data(), directory.c_str());
  }
  Finished finished;
  char buffer[4096];
  for (;;) {
    const ssize_t n = read(terminal, buffer, sizeof buffer);  // EIO: the child has closed its side
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    finished.out.append(buffer, static_cast<std::size_t>(n));
  }
  close(terminal);
  finished.exit_code = wait_for(child);
  return finished;
}

Finished CommandLine::run_well(const std::vector<std::string>& arguments) const {
  Finished finished = run(arguments);
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  return finished;
}

void CommandLine::expect_failure(int exit_code, const std::vector<std::string>& arguments,
                                 std::initializer_list<std::string_view> says) const {
  std::string line = "remaps";
  for (const std::string& argument : arguments) line += " " + argument;
  SCOPED_TRACE(line);
  const Finished finished = run(arguments);
  EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
  EXPECT_EQ(finished.out, "");
  EXPECT_EQ(finished.err.find("remaps: error: "), 0u) << finished.err;
  const std::size_t first_line = finished.err.find('\n');
  const bool has_hint = finished.err.find("\nremaps: try: ") == first_line;
  EXPECT_EQ(has_hint, exit_code == 2) << finished.err;
  EXPECT_EQ(std::count(finished.err.begin(), finished.err.end(), '\n'), exit_code == 2 ? 2 : 1)
      << finished.err;
  for (const std::string_view part : says) {
    EXPECT_NE(finished.err.find(part), std::string::npos) << finished.err << "lacks: " << part;
  }
}

std::filesystem::path CommandLine::generate(const std::string& name, const std::string& vertices,
                                            const std::vector<std::string>& more) const {
  std::vector<std::string> arguments{"generate", name, "--vertices", vertices, "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  run_well(arguments);
  return directory() / name;
}

std::vector<std::string> CommandLine::names_here() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory())) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace remaps
