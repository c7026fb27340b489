#include "remaps/formats/gltf_buffers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <string>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are read as they lie in the file");

constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

/// The value of a base64 digit; 64 for what is none. Both alphabets.
unsigned digit_of(char c) {
  if (c >= 'A' && c <= 'Z') return static_cast<unsigned>(c - 'A');
  if (c >= 'a' && c <= 'z') return static_cast<unsigned>(c - 'a') + 26;
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0') + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return 64;
}

template <std::size_t n>
std::array<std::uint32_t, n> read_words(const RandomSource& source, std::uint64_t offset) {
  std::array<char, 4 * n> bytes;
  source.read_at(offset, bytes);
  return std::bit_cast<std::array<std::uint32_t, n>>(bytes);
}

/// Undoes %20 and the like.
std::string decode_percent(const GltfValue& uri, const std::string& text) {
  const auto hex = [&](char c) -> unsigned {
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
    if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10;
    if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A') + 10;
    uri.fail("expected two hexadecimal digits behind %");
  };
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (i + 2 >= text.size()) uri.fail("expected two hexadecimal digits behind %");
    decoded += static_cast<char>(hex(text[i + 1]) * 16 + hex(text[i + 2]));
    i += 2;
  }
  if (decoded.find('\0') != std::string::npos) uri.fail("expected a file name, found a zero in it");
  return decoded;
}

}  // namespace

void GltfBuffer::read(std::uint64_t offset, std::span<char> out) const {
  if (text_bytes_ != 0) {
    read_base64(offset, out);
  } else {
    source_->read_at(begin_ + offset, out);
  }
}

/// Four characters hold three bytes.
void GltfBuffer::read_base64(std::uint64_t offset, std::span<char> out) const {
  std::array<char, 4096> text;
  std::uint64_t at = offset / 3 * 4;
  std::size_t skip = offset % 3;
  for (std::size_t done = 0; done < out.size();) {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(text.size(), text_bytes_ - at));
    source_->read_at(begin_ + at, std::span(text).first(n));
    for (std::size_t i = 0; i < n && done < out.size(); i += 4) {
      std::uint32_t group = 0;
      const std::size_t digits = std::min<std::size_t>(4, n - i);
      for (std::size_t k = 0; k < digits; ++k) {
        const char c = text[i + k];
        const bool padding = c == '=' && k >= 2 && at + n == text_bytes_ && i + 4 >= n;
        const unsigned digit = padding ? 0 : digit_of(c);
        if (digit > 63) source_->fail_at_byte(begin_ + at + i + k, "expected base64");
        group |= digit << (18 - 6 * k);
      }
      for (std::size_t k = skip; k + 1 < digits && done < out.size(); ++k) {
        out[done++] = static_cast<char>(group >> (16 - 8 * k) & 0xFF);
      }
      skip = 0;
    }
    at += n;
  }
}

GltfFile::GltfFile(const std::filesystem::path& path)
    : source_(std::make_shared<RandomSource>(path)), sources_{source_} {
  std::array<char, 4> magic{};
  if (source_->size() >= magic.size()) source_->read_at(0, magic);
  if (std::bit_cast<std::uint32_t>(magic) == kMagic) {
    read_glb();
  } else {
    json_ = read_gltf_json(*source_, 0, source_->size());
  }
}

void GltfFile::read_glb() {
  constexpr std::uint64_t kHeader = 12, kChunkHeader = 8;
  const std::array<std::uint32_t, 3> header = read_words<3>(*source_, 0);
  const std::uint64_t length = header[2];
  if (header[1] != 2) {
    source_->fail_at_byte(4, fmt::format("expected glTF 2, found version {}", header[1]));
  }
  if (length > source_->size()) {
    source_->fail_at_byte(8, fmt::format("the header announces {} bytes, but the file has only {}",
                                         length, source_->size()));
  }
  std::uint64_t at = kHeader;
  const auto next_chunk = [&]() {
    const std::array<std::uint32_t, 2> chunk = read_words<2>(*source_, at);
    at += kChunkHeader;
    if (chunk[0] > length - at) {
      source_->fail_at_byte(at - kChunkHeader,
                            fmt::format("the chunk announces {} bytes, but there are only {}",
                                        chunk[0], length - at));
    }
    return chunk;
  };
  if (length < kHeader + kChunkHeader) source_->fail_at_byte(8, "expected a chunk of JSON");
  const auto [json_bytes, json_type] = next_chunk();
  if (json_type != kJsonChunk) source_->fail_at_byte(16, "expected a chunk of JSON");
  json_ = read_gltf_json(*source_, at, json_bytes);
  at += json_bytes;
  if (length < at + kChunkHeader) return;
  const auto [bin_bytes, bin_type] = next_chunk();
  if (bin_type != kBinChunk) return;
  bin_begin_ = at;
  bin_bytes_ = bin_bytes;
}

GltfBuffer GltfFile::open_buffer(const GltfValue& buffer) {
  const std::uint64_t bytes = buffer.require("byteLength").whole();
  const std::optional<GltfValue> uri = buffer.find("uri");
  if (uri) {
    const std::string text = uri->text();
    return text.starts_with("data:") ? open_data(*uri, text, bytes)
                                     : open_beside(*uri, text, bytes);
  }
  if (buffer.place() != "buffers[0]" || !bin_begin_) {
    buffer.fail(
        "expected a uri: only the first buffer of a .glb may go without, which has its data "
        "in a chunk of its own");
  }
  if (bytes > bin_bytes_) {
    buffer.fail(fmt::format("announces {} bytes, but the chunk at byte {} has only {}", bytes,
                            *bin_begin_, bin_bytes_));
  }
  return {source_, *bin_begin_, bytes};
}

GltfBuffer GltfFile::open_data(const GltfValue& uri, const std::string& text, std::uint64_t bytes) {
  const std::size_t comma = text.find(',');
  const std::string_view media = std::string_view(text).substr(0, comma);
  if (comma == std::string::npos || !media.ends_with(";base64")) {
    uri.fail("expected data in base64; others are not supported");
  }
  const DataPayload& payload = payload_of(uri, std::string_view(text).substr(comma + 1));
  std::uint64_t digits = payload.bytes;
  if (digits > 0 && digits % 4 == 0) {
    std::array<char, 2> last{};
    source_->read_at(payload.offset + digits - 2, last);
    if (last[1] == '=') digits -= last[0] == '=' ? 2U : 1U;
  }
  const std::uint64_t there = digits / 4 * 3 + (digits % 4 > 1 ? digits % 4 - 1 : 0);
  if (bytes > there) {
    uri.fail(fmt::format("{} bytes are announced, but {} characters of base64 hold only {}", bytes,
                         payload.bytes, there));
  }
  return {source_, payload.offset, bytes, payload.bytes};
}

/// @param mark  what read_gltf_json left behind the comma: "@N"
const DataPayload& GltfFile::payload_of(const GltfValue& uri, std::string_view mark) const {
  std::size_t number = json_.payloads.size();
  const char* const end = mark.data() + mark.size();
  const bool is_mark =
      mark.starts_with('@') && std::from_chars(mark.data() + 1, end, number).ptr == end;
  // Escapes hide the comma or the payload from it.
  if (!is_mark || number >= json_.payloads.size() || json_.payloads[number].escaped) {
    uri.fail("expected base64 without a backslash in the data");
  }
  return json_.payloads[number];
}

GltfBuffer GltfFile::open_beside(const GltfValue& uri, const std::string& text,
                                 std::uint64_t bytes) {
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos && colon < text.find('/')) {
    uri.fail(fmt::format("expected a file beside this one, found the scheme {}",
                         text.substr(0, colon + 1)));
  }
  const std::filesystem::path name = decode_percent(uri, text);
  if (name.empty() || name.is_absolute()) uri.fail("expected the relative path of a file");
  std::shared_ptr<const RandomSource> source;
  try {
    source = std::make_shared<RandomSource>(path().parent_path() / name);
  } catch (const InputError& error) {
    uri.fail(error.what());
  }
  if (bytes > source->size()) {
    uri.fail(fmt::format("{} bytes are announced, but {} has only {}", bytes,
                         source->path().string(), source->size()));
  }
  sources_.push_back(source);
  return {source, 0, bytes};
}

}  // namespace remaps
