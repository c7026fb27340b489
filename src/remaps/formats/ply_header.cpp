#include "remaps/formats/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

/// The least bytes of one record. In text a value takes a character and a separator.
std::uint64_t least_record_size(const PlyElement& element, PlyEncoding encoding) {
  std::uint64_t size = 0;
  for (const PlyProperty& property : element.properties) {
    size +=
        encoding == PlyEncoding::ascii ? 2 : size_of(property.count_type.value_or(property.type));
  }
  return size;
}

std::optional<PlyType> type_named(std::string_view name) {
  static constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::int8},       {"int8", PlyType::int8},      {"uchar", PlyType::uint8},
      {"uint8", PlyType::uint8},     {"short", PlyType::int16},    {"int16", PlyType::int16},
      {"ushort", PlyType::uint16},   {"uint16", PlyType::uint16},  {"int", PlyType::int32},
      {"int32", PlyType::int32},     {"uint", PlyType::uint32},    {"uint32", PlyType::uint32},
      {"int64", PlyType::int64},     {"uint64", PlyType::uint64},  {"float", PlyType::float32},
      {"float32", PlyType::float32}, {"double", PlyType::float64}, {"float64", PlyType::float64}};
  for (const auto& [known, type] : kNames) {
    if (known == name) return type;
  }
  return std::nullopt;
}

class HeaderParser {
 public:
  explicit HeaderParser(ByteSource& source) : source_(source) {}

  PlyHeader parse() {
    source_.require(ByteSource::kDefaultBuffer);
    read_magic();
    while (next_line()) parse_line();
    if (!encoding_) fail("the header has no 'format' line");
    header_.encoding = *encoding_;
    header_.data_offset = source_.offset();
    check_counts();
    return std::move(header_);
  }

 private:
  void read_magic() {
    if (source_.available() < 4 || std::memcmp(source_.data(), "ply", 3) != 0) {
      source_.fail_at_byte(0, "expected 'ply' as the first line");
    }
    const char* const first = source_.data();
    const bool old_mac = first[3] == '\r' && source_.available() > 4 && first[4] != '\n';
    line_end_ = old_mac ? '\r' : '\n';
    next_line();
  }

  /// Splits the next line into words and passes over it; false when it ends the header.
  bool next_line() {
    ++line_;
    const char* const first = source_.data();
    const void* const end = std::memchr(first, line_end_, source_.available());
    if (end == nullptr) {
      fail(source_.exhausted() ? "the file ends within the header, expected 'end_header'"
                               : "expected a header of at most 1 MiB");
    }
    split({first, static_cast<std::size_t>(static_cast<const char*>(end) - first)});
    source_.consume(static_cast<std::size_t>(static_cast<const char*>(end) - first) + 1);
    return words_.empty() || words_[0] != "end_header";
  }

  void split(std::string_view line) {
    constexpr std::string_view kBlanks = " \t\r\v\f";
    words_.clear();
    for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
      const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
      words_.push_back(line.substr(at, end - at));
      at = line.find_first_not_of(kBlanks, end);
    }
  }

  void parse_line() {
    if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") return;
    if (words_[0] == "format") {
      parse_format();
    } else if (words_[0] == "element") {
      parse_element();
    } else if (words_[0] == "property") {
      parse_property();
    } else if (!header_.elements.empty()) {
      // Before the elements such a line can only be a remark: Blender 2.4 forgot the word
      // 'comment'.
      fail(fmt::format("expected a PLY header line, found '{}'", words_[0].substr(0, 40)));
    }
  }

  void parse_format() {
    if (words_.size() < 2) fail("expected the name of a format");
    if (words_[1] == "ascii") {
      encoding_ = PlyEncoding::ascii;
    } else if (words_[1] == "binary_little_endian") {
      encoding_ = PlyEncoding::little_endian;
    } else if (words_[1] == "binary_big_endian") {
      encoding_ = PlyEncoding::big_endian;
    } else {
      fail("expected format ascii, binary_little_endian or binary_big_endian");
    }
  }

  void parse_element() {
    if (words_.size() < 3) fail("expected 'element NAME COUNT'");
    const std::string_view text = words_[2];
    std::uint64_t count = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (error != std::errc() || end != text.data() + text.size()) {
      fail(fmt::format("expected a count of elements, found '{}'", text.substr(0, 40)));
    }
    if (header_.find(words_[1]) != nullptr) {
      fail(fmt::format("a second element '{}'", words_[1].substr(0, 40)));
    }
    header_.elements.push_back({std::string(words_[1]), count, {}});
  }

  void parse_property() {
    if (header_.elements.empty()) fail("expected an element before its properties");
    const bool list = words_.size() > 1 && words_[1] == "list";
    if (words_.size() < (list ? 5U : 3U)) {
      fail("expected 'property TYPE NAME' or 'property list COUNT-TYPE TYPE NAME'");
    }
    PlyProperty property{std::string(words_[list ? 4 : 2]), parse_type(words_[list ? 3 : 1]), {}};
    if (list) {
      property.count_type = parse_type(words_[2]);
      if (!is_integer(*property.count_type)) fail("expected an integer type for a list's count");
    }
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType parse_type(std::string_view name) const {
    const std::optional<PlyType> type = type_named(name);
    if (!type) fail(fmt::format("expected a scalar type, found '{}'", name.substr(0, 40)));
    return *type;
  }

  void check_counts() const {
    // The last value of a text file needs no separator.
    std::uint64_t left = source_.remaining() + (header_.encoding == PlyEncoding::ascii ? 1 : 0);
    for (const PlyElement& element : header_.elements) {
      const std::uint64_t size = least_record_size(element, header_.encoding);
      if (size == 0) continue;
      if (element.count > left / size) {
        source_.fail_at_byte(
            header_.data_offset,
            fmt::format("the header announces {} '{}' of at least {} bytes each, "
                        "but {} for them",
                        element.count, element.name, size, source_.room_text(left)));
      }
      left -= element.count * size;
    }
  }

  [[noreturn]] void fail(std::string_view what) const {
    throw InputError(
        fmt::format("{}: line {}: {}", source_.path().string(), line_, printable(what)));
  }

  ByteSource& source_;
  PlyHeader header_{};
  std::optional<PlyEncoding> encoding_;
  char line_end_ = '\n';
  std::uint64_t line_ = 0;
  std::vector<std::string_view> words_;
};

}  // namespace

const PlyProperty* PlyElement::find(std::string_view wanted, std::string_view other_name) const {
  for (const PlyProperty& property : properties) {
    if (property.name == wanted || (!other_name.empty() && property.name == other_name)) {
      return &property;
    }
  }
  return nullptr;
}

const PlyElement* PlyHeader::find(std::string_view wanted) const {
  for (const PlyElement& element : elements) {
    if (element.name == wanted) return &element;
  }
  return nullptr;
}

PlyHeader read_ply_header(ByteSource& source) {
  return HeaderParser(source).parse();
}

}  // namespace remaps
