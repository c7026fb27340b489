#pragma once

#include <cstdint>
#include <string_view>

#include "remaps/formats/byte_source.h"
#include "remaps/formats/ply_header.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {

/// Which record is being read, for error messages.
struct PlyPlace {
  const PlyElement* element = nullptr;
  std::uint64_t record = 0;
};

/// Reads values of a binary PLY one after the other. PlyTextCursor has the same members, so that
/// one traversal of the records serves both. Amounts to skip are in units of size_in_file.
class PlyBinaryCursor {
 public:
  PlyBinaryCursor(ByteSource& source, bool big_endian) : source_(source), swap_(big_endian) {}

  static constexpr bool kBinary = true;
  static std::uint64_t size_in_file(PlyType type) { return size_of(type); }
  bool big_endian() const { return swap_; }
  std::uint64_t offset() const { return source_.offset(); }

  double real(PlyType type);
  double coordinate(PlyType type) { return real(type); }
  /// Negative values wrap round: they are above any valid index or count.
  std::uint64_t integer(PlyType type);
  void skip(std::uint64_t bytes);
  /// The bytes in the buffer, at least `wanted` of them unless the file ends; and passes over some.
  std::string_view ahead(std::size_t wanted) {
    const std::size_t n = source_.require(wanted);
    return {source_.data(), n};
  }
  void pass(std::size_t bytes) { source_.consume(bytes); }
  /// Fails at once if the file has no room for n values.
  void expect_list(std::uint64_t n, PlyType type);
  /// Throws InputError about the value just read, of this type, naming its place.
  [[noreturn]] void fail(PlyType type, std::string_view what) const;

  PlyPlace place;

 private:
  const char* take(std::size_t n) {
    if (source_.require(n) < n) fail_at_end();
    const char* const at = source_.data();
    source_.consume(n);
    return at;
  }
  [[noreturn]] void fail_at_end() const;

  ByteSource& source_;
  bool swap_;
};

/// Reads values of an ASCII PLY one after the other; any blanks and line ends separate them.
class PlyTextCursor {
 public:
  explicit PlyTextCursor(ByteSource& source) : scanner_(source) {}

  static constexpr bool kBinary = false;
  static std::uint64_t size_in_file(PlyType) { return 1; }
  std::uint64_t offset() const { return scanner_.source().offset(); }

  double real(PlyType type);
  double coordinate(PlyType type);
  std::uint64_t integer(PlyType type);
  void skip(std::uint64_t values);
  void expect_list(std::uint64_t n, PlyType type);
  [[noreturn]] void fail(PlyType type, std::string_view what) const;

  PlyPlace place;

 private:
  /// Goes to the next word, which must be there.
  void go_to_value(PlyType type);

  TextScanner scanner_;
};

}  // namespace remaps
