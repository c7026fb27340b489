#include "remaps/formats/text_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace remaps {
namespace {

bool ends_word(char c) {
  return is_blank(c) || c == '\n';
}

/// std::from_chars refuses what underflows to zero; a coordinate of 1e-60 in a float file is 0.
template <class Real>
std::from_chars_result read_number(const char* first, const char* last, Real& value) {
  auto result = std::from_chars(first, last, value);
  if constexpr (std::is_floating_point_v<Real>) {
    if (result.ec == std::errc::result_out_of_range) {
      long double wide = 1;
      const auto again = std::from_chars(first, last, wide);
      if (again.ec == std::errc() && std::fabs(wide) < 1) {
        value = static_cast<Real>(wide);
        result = again;
      }
    }
  }
  return result;
}

/// True if what is out of range is a number up to the end of the word.
template <class Real>
bool is_number_in_full(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Real value = 0;
  return std::from_chars(word.data(), word.data() + word.size(), value).ptr ==
         word.data() + word.size();
}

/// What the C library of Windows writes for NaN and infinities: "1.#INF", "-1.#IND", "1.#QNAN00".
bool is_windows_nonfinite(std::string_view word) {
  if (word.starts_with('+') || word.starts_with('-')) word.remove_prefix(1);
  if (!word.starts_with("1.#")) return false;
  word.remove_prefix(3);
  for (const std::string_view name : {"INF", "IND", "QNAN", "SNAN", "J", "R"}) {
    if (!word.starts_with(name)) continue;
    return word.find_first_not_of('0', name.size()) == std::string_view::npos;
  }
  return false;
}

}  // namespace

void TextScanner::skip_blanks() {
  for (;;) {
    const char* p = source_.data();
    while (is_blank(*p)) ++p;
    source_.consume(static_cast<std::size_t>(p - source_.data()));
    if (source_.available() > 0 || source_.exhausted()) break;
    source_.require(kLongestWord);
  }
  source_.require(kLongestWord);
}

void TextScanner::skip_space() {
  for (;;) {
    const char* const end = source_.data() + source_.available();
    const char* p = source_.data();
    while (p != end && ends_word(*p)) ++p;
    source_.consume(static_cast<std::size_t>(p - source_.data()));
    if (source_.available() > 0 || source_.exhausted()) break;
    source_.require(kLongestWord);
  }
  source_.require(kLongestWord);
}

char TextScanner::skip_line() {
  char last = 0;
  for (;;) {
    const char* const first = source_.data();
    const std::size_t n = source_.available();
    const void* const found = n == 0 ? nullptr : std::memchr(first, '\n', n);
    const char* const stop = found != nullptr ? static_cast<const char*>(found) : first + n;
    for (const char* p = stop; p != first;) {
      if (*--p == '\r') continue;
      last = *p;
      break;
    }
    if (found != nullptr) {
      source_.consume(static_cast<std::size_t>(stop - first) + 1);
      return last;
    }
    source_.consume(n);
    if (source_.require(1) == 0) return last;
  }
}

bool TextScanner::skip_escaped_line_end() {
  if (peek(0) != '\\') return false;
  const std::size_t end = peek(1) == '\r' ? 2 : 1;
  if (peek(end) != '\n') return false;
  source_.consume(std::min(end + 1, source_.available()));
  return true;
}

void TextScanner::skip_word() {
  skip_space();
  if (at_end()) fail("the file ends where a value was expected");
  word();
}

std::string_view TextScanner::word() {
  const char* const first = source_.data();
  const char* p = first;
  while (!ends_word(*p)) ++p;
  const auto length = static_cast<std::size_t>(p - first);
  if (length == source_.available() && !source_.exhausted()) {
    fail(fmt::format("expected a word of at most {} bytes", kLongestWord));
  }
  source_.consume(length);
  return {first, length};
}

/// As word, up to a backslash, and does not pass over it.
std::string_view TextScanner::word_ahead() const {
  const char* const end = source_.data() + source_.available();
  const char* p = source_.data();
  while (p != end && !ends_word(*p) && *p != '\\') ++p;
  return {source_.data(), static_cast<std::size_t>(p - source_.data())};
}

/// Passes over the number ahead, if there is one.
template <class Number>
bool TextScanner::try_number(char stop, Number& value, bool& out_of_range) {
  const char* const end = source_.data() + source_.available();
  const char* first = source_.data();
  if (*first == '+' && first + 1 < end && first[1] != '-') ++first;
  const auto [last, error] = read_number(first, end, value);
  if (error == std::errc() && (ends_word(*last) || *last == stop || *last == '\\') &&
      (last != end || source_.exhausted())) {
    source_.consume(static_cast<std::size_t>(last - source_.data()));
    return true;
  }
  out_of_range = error == std::errc::result_out_of_range;
  return false;
}

template <class Number>
Number TextScanner::number(char stop, std::string_view kind) {
  Number value = 0;
  bool out_of_range = false;
  if (try_number(stop, value, out_of_range)) return value;
  if (out_of_range) fail(fmt::format("'{}' is out of the range of its type", word()));
  fail_expected(kind);
}

template <class Number>
double TextScanner::coordinate_as() {
  Number value = 0;
  bool out_of_range = false;
  if (try_number('\n', value, out_of_range)) return static_cast<double>(value);
  const std::string_view ahead = word_ahead();
  if (!(out_of_range ? is_number_in_full<Number>(ahead) : is_windows_nonfinite(ahead)))
    fail_expected("a number");
  source_.consume(ahead.size());
  return std::numeric_limits<double>::quiet_NaN();
}

double TextScanner::coordinate() {
  return coordinate_as<double>();
}

double TextScanner::float_coordinate() {
  return coordinate_as<float>();
}

double TextScanner::real() {
  return number<double>('\n', "a number");
}

float TextScanner::real_float() {
  return number<float>('\n', "a number");
}

std::int64_t TextScanner::integer(char stop) {
  return number<std::int64_t>(stop, "an integer");
}

void TextScanner::fail_expected(std::string_view what) {
  if (at_end()) fail(fmt::format("expected {}, found the end of the file", what));
  if (at_line_end()) fail(fmt::format("expected {}, found the end of the line", what));
  constexpr std::size_t kShown = 40;
  const std::uint64_t at = source_.offset();
  const std::string_view found = word();
  source_.fail_at_line(at, fmt::format("expected {}, found '{}{}'", what, found.substr(0, kShown),
                                       found.size() > kShown ? "..." : ""));
}

void TextScanner::fail(std::string_view what) const {
  source_.fail_at_line(source_.offset(), what);
}

}  // namespace remaps
