#include <cstdio>
#include <exception>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "fuzz_targets.h"
#include "remaps/base/errors.h"
#include "remaps/codec/archive.h"
#include "remaps/generate/base_shapes.h"
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

/// A coloured mesh of one of the built-in shapes, with details.
store::Bytes archive_of(BaseShape shape, unsigned levels, codec::Wavelet wavelet) {
  const ShapeMesh base = make_base_mesh(shape);
  codec::SemiRegularMesh mesh;
  mesh.base_vertices = narrow<std::uint32_t>(base.positions.size());
  mesh.levels = levels;
  for (const Triangle& t : base.triangles) {
    mesh.base.push_back(
        {narrow<std::uint32_t>(t[0]), narrow<std::uint32_t>(t[1]), narrow<std::uint32_t>(t[2])});
  }
  MemoryBudget budget(16 << 20);
  const codec::SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, levels, budget);
  mesh.position = base.positions;
  mesh.position.resize(hierarchy.vertices());
  for (std::uint32_t v = mesh.base_vertices; v < hierarchy.vertices(); ++v) {
    const double size = levels > 0 && v < hierarchy.vertices(1) ? 0.05 : 0.01;
    mesh.position[v] = size * Vec3{double(v * 7 % 11) - 5, double(v % 3) - 1, double(v % 5) - 2};
  }
  codec::from_details(hierarchy, codec::Wavelet::kButterfly, levels, mesh.position);
  mesh.signals.resize(1);
  for (const Vec3& p : mesh.position) {
    mesh.signals[0].value.push_back({p.x > 0 ? 1.0 : 0.25, p.y > 0 ? 0.5 : 0.0, 0.75});
  }
  return codec::encode_mesh(std::move(mesh), {.wavelet = wavelet, .bitplanes = 8}, budget);
}

void write_archives(const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  const store::Bytes closed =
      archive_of(BaseShape::kIcosahedron, 2, codec::Wavelet::kLiftedButterfly);
  write_file(directory / "closed", closed);
  write_file(directory / "beginning", Input(closed).first(closed.size() / 2));
  const codec::RatePoint points[] = {{200, 30}, {400, 40.5f}};
  write_file(directory / "table", codec::seal_archive(codec::Archive(closed, "closed"),
                                                      closed.size(), closed.size(), points));
  write_file(directory / "open", archive_of(BaseShape::kDisk, 3, codec::Wavelet::kLoop));
  write_file(directory / "torus", archive_of(BaseShape::kTorus, 1, codec::Wavelet::kButterfly));
  write_file(directory / "level-0", archive_of(BaseShape::kDoubleTorus, 0, codec::Wavelet::kLoop));
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
  write_archives(corpus / "archive");
}

}  // namespace
}  // namespace remaps::fuzz

/// Writes the seeds that are cut from a bundle, and archives; after a change of a format, run it on
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
