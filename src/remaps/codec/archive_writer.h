#pragma once

#include <span>
#include <utility>

#include "remaps/codec/archive.h"

namespace remaps::codec {

/// Puts the parts of an archive together; fills the counts of bytes and points in the header.
store::Bytes assemble_archive(const ArchiveHeader& header, store::ByteSpan base,
                              store::ByteSpan geometry,
                              std::span<const std::pair<SignalHeader, store::Bytes>> signals,
                              std::span<const RatePoint> points);

}  // namespace remaps::codec
