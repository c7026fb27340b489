#include "standard_output.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "remaps/base/errors.h"

namespace remaps::cli {

void print(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) {
    throw IoError(fmt::format("writing to standard output: {}", std::strerror(errno)));
  }
}

void flush_output() {
  if (std::fflush(stdout) != 0) {
    throw IoError(fmt::format("writing to standard output: {}", std::strerror(errno)));
  }
}

void log_line(std::string_view text) {
  const std::string line = fmt::format("remaps: {}\n", text);
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace remaps::cli
