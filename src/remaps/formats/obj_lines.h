#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/formats/text_scanner.h"
#include "remaps/mesh/face_labels.h"

namespace remaps {

/// The file as logical lines, of which those that begin with 'v', 'vt', 'vn' and 'f' matter.
class ObjLines {
 public:
  explicit ObjLines(ByteSource& source) : scanner_(source) {}

  enum class Kind { vertex, texture, normal, face, other };

  bool at_end() const { return scanner_.at_end(); }
  TextScanner& scanner() { return scanner_; }

  /// Passes over the keyword of the line ahead.
  Kind begin_line() {
    scanner_.skip_blanks();
    const char first = scanner_.peek(0);
    comment_ = first == '#';
    if (first != 'v' && first != 'f') return Kind::other;
    if (ends_keyword(scanner_.peek(1))) {
      scanner_.consume(1);
      return first == 'v' ? Kind::vertex : Kind::face;
    }
    const char second = scanner_.peek(1);
    const bool known = first == 'v' && (second == 't' || second == 'n');
    if (!known || !ends_keyword(scanner_.peek(2))) return Kind::other;
    scanner_.consume(2);
    return second == 't' ? Kind::texture : Kind::normal;
  }

  /// Passes over blanks and over line ends hidden by a backslash; true if the line has more to say.
  bool next_value() {
    do {
      scanner_.skip_blanks();
    } while (scanner_.skip_escaped_line_end());
    return !scanner_.at_line_end() && scanner_.peek(0) != '#';
  }

  /// Passes over the rest of the line. A backslash at the end of a comment (a Windows path, say)
  /// hides nothing.
  void end_line() {
    while (scanner_.skip_line() == '\\' && !comment_ && !scanner_.at_end()) {
    }
  }

 private:
  static bool ends_keyword(char c) { return is_blank(c) || c == '\n' || c == '\\'; }

  TextScanner scanner_;
  bool comment_ = false;
};

/// The numbers of a corner, v, v/t, v//n or v/t/n: 0 for what is not there.
struct ObjCorner {
  std::int64_t vertex = 0;
  std::array<std::int64_t, 2> pool{};  // texture, normal
};

inline ObjCorner read_corner(TextScanner& scanner) {
  ObjCorner corner;
  corner.vertex = scanner.integer('/');
  for (std::int64_t& number : corner.pool) {
    if (scanner.peek(0) != '/') break;
    scanner.consume(1);
    const char next = scanner.peek(0);
    if (next != '/' && next != '\\' && !is_blank(next) && next != '\n')
      number = scanner.integer('/');
  }
  return corner;
}

/// The labels in force at a line: what the last lines 'o', 'g' and 'usemtl' before it said.
class ObjLabels {
 public:
  /// Takes a line of another kind in, if it is one of those.
  void read(ObjLines& lines) {
    TextScanner& scanner = lines.scanner();
    for (std::size_t i = 0; i < kKeyword.size(); ++i) {
      if (!starts_with(scanner, kKeyword[i])) continue;
      scanner.consume(kKeyword[i].size());
      label_[i] = kNone;
      while (lines.next_value()) {
        label_[i] = mix_label(label_[i], read_word(scanner));
      }
      seen_[i] = true;
      return;
    }
  }

  /// Names of those that the file has.
  std::vector<std::string> seen() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < kName.size(); ++i) {
      if (seen_[i]) names.emplace_back(kName[i]);
    }
    return names;
  }

  /// One that differs where any of the named ones does.
  FaceLabel of(std::span<const std::string> names) const {
    FaceLabel label = kNone;
    for (std::size_t i = 0; i < kName.size(); ++i) {
      if (std::find(names.begin(), names.end(), kName[i]) != names.end())
        label = mix_label(label, label_[i]);
    }
    return label;
  }

 private:
  static constexpr std::array<std::string_view, 3> kKeyword = {"o", "g", "usemtl"};
  static constexpr std::array<std::string_view, 3> kName = {"object", "group", "material"};
  static constexpr FaceLabel kNone = 1;  // before the first such line

  /// Up to a blank or a line end, also a hidden one.
  static std::string read_word(TextScanner& scanner) {
    const auto goes_on = [&] {
      const char c = scanner.peek(0);
      if (is_blank(c) || c == '\n') return false;
      return c != '\\' || (scanner.peek(1) != '\n' && scanner.peek(1) != '\r');
    };
    std::string word;
    do {
      if (word.size() == TextScanner::kLongestWord) scanner.fail("expected a shorter name");
      word += scanner.peek(0);
      scanner.consume(1);
    } while (goes_on());
    return word;
  }

  static bool starts_with(const TextScanner& scanner, std::string_view keyword) {
    for (std::size_t i = 0; i < keyword.size(); ++i) {
      if (scanner.peek(i) != keyword[i]) return false;
    }
    const char next = scanner.peek(keyword.size());
    return is_blank(next) || next == '\n' || next == '\\';
  }

  std::array<FaceLabel, 3> label_{kNone, kNone, kNone};
  std::array<bool, 3> seen_{};
};

}  // namespace remaps
