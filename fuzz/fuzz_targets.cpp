#include "fuzz_targets.h"

#include <unistd.h>

#include "remaps/store/file.h"

namespace remaps::fuzz {

void run_target(std::string_view name, Input input) {
  if (name == "sections") {
    fuzz_sections(input);
  } else if (name == "bundle") {
    fuzz_bundle(input);
  } else if (name == "archive") {
    fuzz_archive(input);
  } else {
    fuzz_mesh(input, name);
  }
}

const std::filesystem::path& scratch_directory() {
  static constexpr const char* kInMemory = "/dev/shm";
  static const store::TempDir directory(::access(kInMemory, W_OK | X_OK) == 0
                                            ? std::filesystem::path(kInMemory)
                                            : std::filesystem::temp_directory_path());
  return directory.path();
}

void write_file(const std::filesystem::path& path, Input bytes) {
  store::File file = store::File::create(path);
  file.write_at(0, bytes);
  file.close();
}

}  // namespace remaps::fuzz
