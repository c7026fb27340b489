#include "remaps/pipeline/staged.h"

#include "remaps/base/errors.h"
#include "remaps/pipeline/bundle.h"

namespace remaps::pipeline {

void check_bundle_target(const std::filesystem::path& bundle) {
  if (!std::filesystem::exists(bundle)) return;
  const bool replaceable =
      std::filesystem::is_directory(bundle) &&
      (std::filesystem::exists(bundle / kManifestName) || std::filesystem::is_empty(bundle));
  if (!replaceable)
    throw IoError(bundle.string() + ": exists and is not a bundle; it is left alone");
}

}  // namespace remaps::pipeline
