#include "remaps/formats/format_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "remaps/formats/file_extension.h"
#include "remaps/formats/stl_layout.h"

namespace remaps {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
/// So many bytes tell whether a file is text.
constexpr std::size_t kLookedAt = 4096;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Finds a word written in lower case, in whatever case it is there.
bool contains_word(std::string_view text, std::string_view word) {
  const auto same = [](char a, char b) { return lower(a) == b; };
  return std::search(text.begin(), text.end(), word.begin(), word.end(), same) != text.end();
}

bool is_text(std::string_view head) {
  const auto control = [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return (code < ' ' && kBlanks.find(c) == std::string_view::npos) || code == 0x7f;
  };
  const std::string_view part = head.substr(0, kLookedAt);
  return std::none_of(part.begin(), part.end(), control);
}

/// The first word of a text outside comments; empty if there is none.
std::string_view first_word(std::string_view text) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
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

/// True when some line of the text is a vertex of an OBJ: 'v' and a number.
bool has_obj_vertex(std::string_view text) {
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at)) {
    at = text.find_first_not_of(kBlanks, at);
    if (at == std::string_view::npos) break;
    if (text[at] != 'v') continue;
    const std::size_t value = text.find_first_not_of(" \t", at + 1);
    if (value == std::string_view::npos || value == at + 1) continue;
    if (is_digit(text[value]) ||
        std::string_view("+-.").find(text[value]) != std::string_view::npos)
      return true;
  }
  return false;
}

/// The corners of the first triangles of a binary STL are numbers that a mesh may have.
bool has_stl_triangles(std::string_view head) {
  constexpr std::size_t kTried = 16;
  std::size_t at = kStlHeader;
  for (std::size_t i = 0; i < kTried && at + kStlTriangle <= head.size(); ++i, at += kStlTriangle) {
    float value[9];
    std::memcpy(value, head.data() + at + kStlNormal, sizeof value);
    for (const float x : value) {
      if (x != 0 && !(std::fabs(x) > 1e-30F && std::fabs(x) < 1e30F)) return false;
    }
  }
  return at > kStlHeader;
}

/// A binary STL has no mark. Its size tells: a header, the number of triangles, 50 bytes each.
/// Where more follows, or the size is not known, the first triangles decide.
bool is_binary_stl(std::string_view head, const ByteSource& source) {
  if (head.size() < kStlHeader) return false;
  const std::uint64_t triangles = stl_triangle_count(head.data());
  const std::uint64_t size = kStlHeader + triangles * kStlTriangle;
  if (source.size_is_known() && size == source.size()) return true;
  return triangles > 0 && size <= source.size() && !is_text(head) && has_stl_triangles(head);
}

std::optional<MeshFormat> format_of_extension(const std::string& extension, bool text) {
  if (extension == ".ply") return MeshFormat::ply;
  if (extension == ".stl") return text ? MeshFormat::ascii_stl : MeshFormat::binary_stl;
  if (!text) return std::nullopt;
  if (extension == ".obj") return MeshFormat::obj;
  if (extension == ".off") return MeshFormat::off;
  return std::nullopt;
}

struct Magic {
  std::string_view bytes, name;
};
constexpr Magic kOthers[] = {
    {"PK\x03\x04", "a ZIP archive (3MF?)"},
    {"\x1f\x8b", "gzip data within compressed data"},
    {"\x28\xb5\x2f\xfd", "Zstandard data within compressed data"},
    {"BZh", "bzip2 data; only gzip and Zstandard are decompressed"},
    {"\xfd\x37zXZ", "xz data; only gzip and Zstandard are decompressed"},
    {"\x04\x22\x4d\x18", "LZ4 data; only gzip and Zstandard are decompressed"},
    {"DRACO", "a Draco file"},
    {"OCTM", "an OpenCTM file"},
    {"Kaydara FBX", "an FBX file"},
    {"# vtk", "a VTK file"},
    {"%PDF", "a PDF file"},
    {"\x89PNG", "a PNG image"},
    {"\xff\xd8\xff", "a JPEG image"},
    {"\x89HDF", "an HDF5 file"},
    {"LASF", "a LAS point cloud"},
    {"<", "XML"}};

}  // namespace

std::optional<MeshFormat> detect_format(const ByteSource& source) {
  const std::string_view head(source.data(), source.available());
  if (head.starts_with("ply") && head.size() > 3 && kBlanks.find(head[3]) != std::string_view::npos)
    return MeshFormat::ply;
  if (head.starts_with("glTF")) return MeshFormat::glb;
  if (is_binary_stl(head, source)) return MeshFormat::binary_stl;
  const std::string extension = content_extension(source.path());
  if (!is_text(head)) return format_of_extension(extension, false);
  const std::string_view word = first_word(head);
  if (word.starts_with('{')) return MeshFormat::gltf;
  if (word.ends_with("OFF")) return MeshFormat::off;
  if (contains_word(word.substr(0, 5), "solid") &&
      (extension == ".stl" || contains_word(head, "facet") || contains_word(head, "endsolid")))
    return MeshFormat::ascii_stl;
  if (std::any_of(std::begin(kOthers), std::end(kOthers),
                  [&](const Magic& m) { return head.starts_with(m.bytes); }))
    return std::nullopt;
  if (is_obj_keyword(word) || has_obj_vertex(head)) return MeshFormat::obj;
  return format_of_extension(extension, true);
}

std::string describe_content(std::string_view head) {
  for (const Magic& magic : kOthers) {
    if (head.starts_with(magic.bytes)) return std::string(magic.name);
  }
  constexpr std::size_t kShown = 30;
  if (is_text(head)) {
    std::string_view text = head.substr(0, std::min(head.find_first_of("\r\n"), head.size()));
    const bool cut = text.size() > kShown;
    return fmt::format("text that begins with '{}{}'", printable(text.substr(0, kShown)),
                       cut ? "..." : "");
  }
  std::string bytes;
  for (const char c : head.substr(0, 8))
    bytes += fmt::format(" {:02x}", static_cast<unsigned char>(c));
  return "the bytes" + bytes;
}

void skip_byte_order_mark(ByteSource& source) {
  if (source.require(kByteOrderMark.size()) < kByteOrderMark.size()) return;
  if (std::memcmp(source.data(), kByteOrderMark.data(), kByteOrderMark.size()) == 0)
    source.consume(kByteOrderMark.size());
}

}  // namespace remaps
