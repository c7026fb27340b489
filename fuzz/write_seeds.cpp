#include <cstdio>
#include <exception>
#include <filesystem>
#include <span>
#include <string>

#include "fuzz_targets.h"
#include "remaps/base/errors.h"
#include "remaps/store/file.h"
#include "remaps/store/packing.h"
#include "seed_bundle.h"

namespace remaps::fuzz {
namespace {

constexpr const char* kPartNames[kBundleParts] = {
    "manifest",        "base", "map",          "first-records",
    "first-survivors", "tile", "last-records", "last-survivors"};

void write_seed(const std::filesystem::path& path, std::uint8_t choice, Input content) {
  store::Bytes bytes{std::byte{choice}};
  bytes.insert(bytes.end(), content.begin(), content.end());
  write_file(path, bytes);
}

/// The sections of a log segment as fuzz_sections takes them.
store::Bytes join(const store::Bytes& records, const store::Bytes& survivors) {
  store::Bytes bytes;
  store::Packer packer(bytes);
  packer.put(narrow<std::uint16_t>(records.size()));
  bytes.insert(bytes.end(), records.begin(), records.end());
  bytes.insert(bytes.end(), survivors.begin(), survivors.end());
  return bytes;
}

void write_seeds(const std::filesystem::path& corpus) {
  std::filesystem::create_directories(corpus / "bundle");
  std::filesystem::create_directories(corpus / "sections");
  const SeedBundle bundle;
  for (std::uint8_t i = 0; i < kBundleParts; ++i) {
    write_seed(corpus / "bundle" / kPartNames[i], i, bundle.part(static_cast<BundlePart>(i)));
  }
  const auto part = [&](BundlePart p) { return bundle.part(p); };
  const std::filesystem::path sections = corpus / "sections";
  for (const char* name : {"log-0.bin", "tiles.bin"}) {
    const std::string file = store::read_whole_file(bundle.directory() / name);
    write_seed(sections / name, 0, std::as_bytes(std::span(file)));
  }
  write_seed(sections / "first-segment", 1,
             join(part(BundlePart::first_records), part(BundlePart::first_survivors)));
  write_seed(sections / "last-segment", 1,
             join(part(BundlePart::last_records), part(BundlePart::last_survivors)));
  write_seed(sections / "tile", 2, part(BundlePart::tile));
}

}  // namespace
}  // namespace remaps::fuzz

/// Writes the seeds that are cut from a bundle; after a change of a format, run it on
/// tests/fuzz_corpus.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: remaps_fuzz_seeds tests/fuzz_corpus\n", stderr);
    return 2;
  }
  try {
    remaps::fuzz::write_seeds(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
