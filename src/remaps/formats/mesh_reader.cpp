#include "remaps/formats/mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/formats/file_extension.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

enum class Format { ply, obj, off };

constexpr std::string_view kBlanks = " \t\r\n\v\f";

/// The first word of a text outside comments; empty if there is none.
std::string_view first_word(std::string_view text) {
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    if (!text.starts_with('#')) break;
    text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
  return text.substr(0, std::min(text.find_first_of(kBlanks), text.size()));
}

bool is_obj_keyword(std::string_view word) {
  static constexpr std::string_view kKeywords[] = {
      "v", "vt", "vn", "vp", "f", "l", "p", "g", "o", "s", "mg", "mtllib", "usemtl", "usemap"};
  return std::find(std::begin(kKeywords), std::end(kKeywords), word) != std::end(kKeywords);
}

/// Binary, or the JSON form: no other format opens with a brace.
bool is_gltf(std::string_view head) {
  const std::string_view text = head.starts_with("\xef\xbb\xbf") ? head.substr(3) : head;
  return head.starts_with("glTF") || first_word(text).starts_with("{");
}

/// The name of a format that is known but not read, empty for none. A binary STL has no mark but
/// its size: 80 bytes, the number of triangles, 50 bytes each.
std::string_view unsupported_format(std::string_view head, std::uint64_t file_size) {
  if (head.starts_with("ply")) return "";
  if (head.starts_with("PK\x03\x04")) return "ZIP (3MF)";
  if (head.starts_with("\x1f\x8b") || head.starts_with("\x28\xb5\x2f\xfd"))
    return "compressed data";
  if (head.size() >= 84) {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, head.data() + 80, sizeof triangles);
    if (file_size == 84 + std::uint64_t{triangles} * 50) return "binary STL";
  }
  return first_word(head) == "solid" ? "ASCII STL" : "";
}

std::optional<Format> detect_format(std::string_view head, const std::filesystem::path& path) {
  const std::string_view word = first_word(head);
  const std::string extension = lower_extension(path);
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return Format::ply;
  if (word.ends_with("OFF")) return Format::off;
  if (is_obj_keyword(word) || extension == ".obj") return Format::obj;
  if (extension == ".ply") return Format::ply;
  if (extension == ".off") return Format::off;
  return std::nullopt;
}

[[noreturn]] void refuse(const std::filesystem::path& path, std::string_view found) {
  throw InputError(fmt::format("{}: expected a mesh in PLY, OBJ, OFF or glTF format, found {}",
                               path.string(), found));
}

}  // namespace

std::unique_ptr<IndexedMeshReader> open_mesh_reader(const std::filesystem::path& path) {
  ByteSource source(path);
  source.require(ByteSource::kDefaultBuffer);
  const std::string_view head(source.data(), source.available());
  if (head.empty()) refuse(path, "an empty file (byte 0)");
  if (is_gltf(head)) return make_gltf_reader(std::move(source));
  const std::string_view unsupported = unsupported_format(head, source.size());
  if (!unsupported.empty())
    refuse(path, fmt::format("{} (byte 0), which is not supported", unsupported));
  const std::optional<Format> format = detect_format(head, path);
  if (!format) refuse(path, "none of these (byte 0)");
  switch (*format) {
    case Format::ply:
      return make_ply_reader(std::move(source));
    case Format::off:
      return make_off_reader(std::move(source));
    case Format::obj:
      break;
  }
  if (head.find('\r') != std::string_view::npos && head.find('\n') == std::string_view::npos) {
    refuse(path, "OBJ with lines that end in CR alone (byte 0), which is not supported");
  }
  return make_obj_reader(std::move(source));
}

}  // namespace remaps
