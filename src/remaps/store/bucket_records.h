#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "remaps/base/errors.h"
#include "remaps/store/bucket_file.h"

namespace remaps::store {

/// Decodes the records of a bucket, of differing lengths, piece by piece: decode(at) returns the
/// end of a record. Memory: 256 KiB.
/// @param largest  bytes of the largest record
/// @param what     the records, for messages
/// @throws CorruptionError  the last record does not end with the bucket
template <class Decode>
void for_each_record(const BucketFile& file, std::size_t bucket, std::size_t largest,
                     const char* what, Decode&& decode) {
  constexpr std::uint64_t kPiece = 256 << 10;
  Bytes piece;
  const std::uint64_t total = file.bytes(bucket);
  std::uint64_t offset = 0;
  while (offset < total) {
    const std::uint64_t size = std::min(kPiece, total - offset);
    file.read(bucket, offset, size, piece);
    piece.resize(static_cast<std::size_t>(size) + largest);
    // A record that may be cut off is left to the next piece.
    const std::uint64_t safe = offset + size == total ? size : size - largest;
    const std::byte* at = piece.data();
    while (at < piece.data() + safe) at = decode(at);
    offset += static_cast<std::uint64_t>(at - piece.data());
  }
  if (offset > total) throw CorruptionError(std::string(what) + " do not end where they should");
}

}  // namespace remaps::store
