#include "remaps/formats/mesh_reader.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/formats/format_detection.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

[[noreturn]] void refuse(const ByteSource& source, std::string_view found) {
  throw InputError(fmt::format(
      "{}: expected a mesh in PLY, OBJ, OFF or STL format, plain or compressed with gzip or "
      "Zstandard, or in glTF format, found {} (byte 0{})",
      source.path().string(), found, source.is_compressed() ? " of the decompressed content" : ""));
}

std::unique_ptr<IndexedMeshReader> make_reader(MeshFormat format, ByteSource source) {
  switch (format) {
    case MeshFormat::ply:
      return make_ply_reader(std::move(source));
    case MeshFormat::off:
      return make_off_reader(std::move(source));
    case MeshFormat::binary_stl:
      return make_binary_stl_reader(std::move(source));
    case MeshFormat::ascii_stl:
      return make_ascii_stl_reader(std::move(source));
    case MeshFormat::glb:
    case MeshFormat::gltf:
      if (source.is_compressed()) refuse(source, "glTF, which is read uncompressed only");
      return make_gltf_reader(std::move(source));
    case MeshFormat::obj:
      break;
  }
  const std::string_view head(source.data(), source.available());
  if (head.find('\r') != std::string_view::npos && head.find('\n') == std::string_view::npos) {
    refuse(source, "OBJ with lines that end in CR alone, which is not supported");
  }
  return make_obj_reader(std::move(source));
}

}  // namespace

std::unique_ptr<IndexedMeshReader> open_mesh_reader(const std::filesystem::path& path,
                                                    MemoryBudget* budget) {
  ByteSource source(path, ByteSource::kDefaultBuffer, budget);
  source.require(ByteSource::kDefaultBuffer);
  if (source.available() == 0) refuse(source, "an empty file");
  const std::optional<MeshFormat> format = detect_format(source);
  if (!format) refuse(source, describe_content({source.data(), source.available()}));
  return make_reader(*format, std::move(source));
}

std::uint64_t guess_content_bytes(const std::filesystem::path& path) {
  try {
    ByteSource source(path);
    source.require(ByteSource::kDefaultBuffer);
    return source.expected_size();
  } catch (const Error&) {
    return 0;
  }
}

}  // namespace remaps
