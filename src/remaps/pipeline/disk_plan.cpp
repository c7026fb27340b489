#include "remaps/pipeline/disk_plan.h"

#include <fmt/format.h>

#include <system_error>

#include "remaps/base/errors.h"
#include "remaps/formats/file_extension.h"
#include "remaps/formats/mesh_reader.h"

namespace remaps::pipeline {
namespace {

/// Temporary bytes for each of the input: docs/design/ingest.md has the measured ones.
constexpr double kTemporaryPerInput = 4;

/// The bytes of a mesh: a .gltf has most of them in other files.
std::uint64_t bytes_of_mesh(const std::filesystem::path& input) {
  if (lower_extension(input) == ".gltf") {
    try {
      return open_mesh_reader(input)->bytes_total();
    } catch (const Error&) {
      return 0;
    }
  }
  return guess_content_bytes(input);
}

double mebibytes(std::uint64_t bytes) {
  return double(bytes) / (1 << 20);
}

}  // namespace

std::uint64_t temporary_bytes_needed(const std::filesystem::path& input) {
  return static_cast<std::uint64_t>(kTemporaryPerInput * double(bytes_of_mesh(input)));
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
