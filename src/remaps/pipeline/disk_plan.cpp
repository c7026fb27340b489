#include "remaps/pipeline/disk_plan.h"

#include <fmt/format.h>

#include <system_error>

#include "remaps/base/errors.h"
#include "remaps/formats/mesh_reader.h"

namespace remaps::pipeline {
namespace {

/// Temporary bytes for each of the input: docs/design/ingest.md has the measured ones.
constexpr double kTemporaryPerInput = 4;

double mebibytes(std::uint64_t bytes) {
  return double(bytes) / (1 << 20);
}

}  // namespace

std::uint64_t temporary_bytes_needed(const std::filesystem::path& input) {
  return static_cast<std::uint64_t>(kTemporaryPerInput * double(guess_content_bytes(input)));
}

void check_disk_space(std::uint64_t needed_bytes, const std::filesystem::path& directory) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(directory, error);
  if (error || space.available >= needed_bytes) return;
  throw BudgetError(fmt::format(
      "{}: temporary files may take {:.0f} MiB but {:.0f} MiB are free; name another directory "
      "with --temp-dir",
      directory.string(), mebibytes(needed_bytes), mebibytes(space.available)));
}

}  // namespace remaps::pipeline
