#include "exit_codes.h"

#include <cstring>
#include <new>
#include <string_view>
#include <system_error>

#include "remaps/base/errors.h"

namespace remaps::cli {
namespace {

template <class T>
bool is_a(const std::exception& error) {
  return dynamic_cast<const T*>(&error) != nullptr;
}

/// IoError carries no error number, only the system's words for it.
bool is_disk_full(const std::exception& error) {
  const std::string_view message = error.what();
  for (const int number : {ENOSPC, EDQUOT, EFBIG}) {
    if (message.find(std::strerror(number)) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

ExitCode exit_code_of(const std::exception& error) {
  if (is_a<UsageError>(error)) return ExitCode::kUsage;
  if (is_a<Cancelled>(error)) return ExitCode::kCancelled;
  if (is_a<InputError>(error)) return ExitCode::kInput;
  if (is_a<GeometryError>(error)) return ExitCode::kGeometry;
  if (is_a<CorruptionError>(error)) return ExitCode::kVerification;
  if (is_a<BudgetError>(error) || is_a<std::bad_alloc>(error)) return ExitCode::kBudget;
  if (is_a<IoError>(error) || is_a<std::system_error>(error)) {
    if (is_disk_full(error)) return ExitCode::kBudget;
    return is_a<IoError>(error) ? ExitCode::kInput : ExitCode::kInternal;
  }
  return ExitCode::kInternal;
}

}  // namespace remaps::cli
