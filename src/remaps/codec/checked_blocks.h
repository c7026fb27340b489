#pragma once

#include <cstdint>
#include <optional>

#include "remaps/store/packing.h"

namespace remaps::codec {

/// The lower half of XXH3-64.
std::uint32_t checksum32(store::ByteSpan bytes);
inline constexpr std::size_t kChecksumBytes = 4;
/// Bytes of a code between two checksums.
inline constexpr std::size_t kBlockBytes = 4096;

/// Appends bytes and their checksum.
void append_checked(store::Bytes& out, store::ByteSpan bytes);
/// Whether the checksum behind `size` bytes is theirs; both must be there.
bool passes_checksum(store::ByteSpan bytes, std::uint64_t at, std::uint64_t size);

/// A code in blocks, each with its checksum.
std::uint64_t bytes_in_blocks(std::uint64_t code_bytes);
void append_in_blocks(store::Bytes& out, store::ByteSpan code);
/// The code out of its blocks, as much as is there.
/// @param bytes       from the first block on; may end anywhere
/// @param code_bytes  of the whole code
store::Bytes code_of_blocks(store::ByteSpan bytes, std::uint64_t code_bytes);
/// The offset of the first block that is there as a whole and fails its checksum.
std::optional<std::uint64_t> first_bad_block(store::ByteSpan bytes, std::uint64_t code_bytes);

}  // namespace remaps::codec
