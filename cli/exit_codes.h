#pragma once

#include <exception>
#include <stdexcept>

namespace remaps::cli {

/// What the process says to its caller. Part of the contract; the help text lists them.
enum class ExitCode : int {
  kDone = 0,
  kInternal = 1,      ///< a bug of ours
  kUsage = 2,         ///< the command line is wrong
  kInput = 3,         ///< an input is missing, unreadable or malformed
  kGeometry = 4,      ///< the surface is not of a kind that can be handled
  kBudget = 5,        ///< not enough memory or disk
  kVerification = 6,  ///< a bundle is damaged
  kCancelled = 130,
};

/// The command line asks for something that cannot be. The message is one line.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The exit code for an exception that ended a command.
ExitCode exit_code_of(const std::exception& error);

}  // namespace remaps::cli
