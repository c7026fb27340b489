#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "remaps/formats/byte_source.h"

namespace remaps {

/// Reads words and numbers from a text file. Lines and runs of blanks may be of any length, a word
/// of at most kLongestWord bytes. A failure names the line it happened in.
class TextScanner {
 public:
  static constexpr std::size_t kLongestWord = 4096;

  /// The source must outlive the scanner and have a buffer of at least 2 * kLongestWord.
  explicit TextScanner(ByteSource& source) : source_(source) {}

  const ByteSource& source() const { return source_; }
  bool at_end() const { return source_.available() == 0 && source_.exhausted(); }

  /// Passes over blanks within the line (space, tab, CR, VT, FF), after which peek(0) is the next
  /// byte that is none, or '\n' at the end of the line and of the file.
  void skip_blanks();
  /// Passes over blanks and line ends.
  void skip_space();
  /// Passes over the rest of the line and its end. Returns the last byte before the end other than
  /// CR, 0 if there was none.
  char skip_line();
  /// Passes over a backslash right before a line end, and over that; false if there is none ahead.
  bool skip_escaped_line_end();
  /// Passes over one word. At the end of the file: fails.
  void skip_word();

  /// The i-th byte ahead; only valid up to the first '\n'.
  char peek(std::size_t i) const { return source_.data()[i]; }
  bool at_line_end() const { return peek(0) == '\n'; }
  void consume(std::size_t n) { source_.consume(n); }

  /// The word ahead (up to a blank or line end), empty at a line end. Passes over it.
  std::string_view word();

  /// Reads the number ahead, correctly rounded to the type; what underflows becomes 0. NaN and
  /// infinities are read: the caller judges. Fails unless a blank, a line end or '\\' follows.
  double real();
  float real_float();
  /// As real or real_float for coordinates: NaN for what is beyond the range, and for what programs
  /// write for NaN and infinities, as "-1.#IND".
  double coordinate();
  double float_coordinate();
  /// Reads the integer ahead. Fails unless a blank, a line end, '\\' or `stop` follows.
  std::int64_t integer(char stop = '\n');

  /// Throws InputError naming the line and what was found: "expected WHAT, found 'WORD'".
  [[noreturn]] void fail_expected(std::string_view what);
  /// Throws InputError naming the line.
  [[noreturn]] void fail(std::string_view what) const;

 private:
  std::string_view word_ahead() const;
  template <class Number>
  Number number(char stop, std::string_view kind);
  template <class Number>
  bool try_number(char stop, Number& value, bool& out_of_range);
  template <class Number>
  double coordinate_as();

  ByteSource& source_;
};

/// True for what separates words within a line.
constexpr bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

}  // namespace remaps
