#include "remaps/codec/checked_blocks.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace remaps::codec {
namespace {

/// Calls visit(offset, bytes) for the blocks of a code until it returns false.
template <class Visit>
void for_blocks(std::uint64_t code_bytes, Visit&& visit) {
  for (std::uint64_t at = 0; code_bytes > 0; at += kBlockBytes + kChecksumBytes) {
    const std::uint64_t size = std::min<std::uint64_t>(code_bytes, kBlockBytes);
    if (!visit(at, size)) return;
    code_bytes -= size;
  }
}

}  // namespace

std::uint32_t checksum32(store::ByteSpan bytes) {
  return static_cast<std::uint32_t>(XXH3_64bits(bytes.data(), bytes.size()));
}

void append_checked(store::Bytes& out, store::ByteSpan bytes) {
  store::Packer packer(out);
  packer.put_array(bytes);
  packer.put(checksum32(bytes));
}

bool passes_checksum(store::ByteSpan bytes, std::uint64_t at, std::uint64_t size) {
  std::uint32_t stored = 0;
  std::memcpy(&stored, bytes.data() + at + size, sizeof stored);
  return stored == checksum32(bytes.subspan(at, size));
}

std::uint64_t bytes_in_blocks(std::uint64_t code_bytes) {
  return code_bytes + kChecksumBytes * ((code_bytes + kBlockBytes - 1) / kBlockBytes);
}

void append_in_blocks(store::Bytes& out, store::ByteSpan code) {
  for_blocks(code.size(), [&](std::uint64_t, std::uint64_t size) {
    append_checked(out, code.first(size));
    code = code.subspan(size);
    return true;
  });
}

store::Bytes code_of_blocks(store::ByteSpan bytes, std::uint64_t code_bytes) {
  store::Bytes code;
  for_blocks(code_bytes, [&](std::uint64_t at, std::uint64_t size) {
    if (at >= bytes.size()) return false;
    store::Packer(code).put_array(bytes.subspan(at, std::min(size, bytes.size() - at)));
    return true;
  });
  return code;
}

std::optional<std::uint64_t> first_bad_block(store::ByteSpan bytes, std::uint64_t code_bytes) {
  std::optional<std::uint64_t> bad;
  for_blocks(code_bytes, [&](std::uint64_t at, std::uint64_t size) {
    if (at + size + kChecksumBytes > bytes.size()) return false;
    if (!passes_checksum(bytes, at, size)) bad = at;
    return !bad;
  });
  return bad;
}

}  // namespace remaps::codec
