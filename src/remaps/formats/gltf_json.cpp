#include "remaps/formats/gltf_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

using nlohmann::json;

constexpr std::size_t kPiece = std::size_t{1} << 16;
constexpr int kDeepest = 64;

/// Copies JSON text without the payloads of its data: URIs.
class TextTaker {
 public:
  explicit TextTaker(GltfJson& to) : to_(to) {}

  /// @param offset  in the file
  void take(char c, std::uint64_t offset) {
    if (in_payload_) {
      DataPayload& payload = to_.payloads.back();
      const bool escaped = std::exchange(escaped_, !escaped_ && c == '\\');
      payload.escaped = payload.escaped || c == '\\';
      if (c != '"' || escaped) {
        ++payload.bytes;
        return;
      }
      in_payload_ = false;
      left_out_ += payload.bytes;
      shifts_.emplace_back(text_.size(), left_out_);
    }
    text_ += c;
    if (!in_string_) {
      in_string_ = c == '"';
      string_ = text_.size();
      escaped_ = false;
    } else if (escaped_) {
      escaped_ = false;
    } else if (c == '\\') {
      escaped_ = true;
    } else if (c == '"') {
      in_string_ = false;
    } else if (c == ',' && text_.compare(string_, 5, "data:") == 0) {
      begin_payload(offset + 1);
    }
  }

  const std::string& text() const { return text_; }

  /// The offset in the JSON of a byte of the text.
  std::uint64_t offset_of(std::size_t at) const {
    std::uint64_t shift = 0;
    for (const auto& [from, left_out] : shifts_) {
      if (from <= at) shift = left_out;
    }
    return at + shift;
  }

 private:
  void begin_payload(std::uint64_t offset) {
    const std::string mark = fmt::format("@{}", to_.payloads.size());
    text_ += mark;
    left_out_ -= mark.size();  // wraps round until the payload is over
    to_.payloads.push_back({offset, 0, false});
    in_payload_ = true;
  }

  GltfJson& to_;
  std::string text_;
  std::size_t string_ = 0;  // where the present string begins
  bool in_string_ = false, escaped_ = false, in_payload_ = false;
  std::uint64_t left_out_ = 0;
  std::vector<std::pair<std::size_t, std::uint64_t>> shifts_;
};

bool is_needed(int depth, const std::string& key) {
  if (key == "extras" || (depth > 1 && key == "name")) return false;
  if (depth > 1) return true;
  static constexpr std::string_view kNeeded[] = {
      "asset",     "scene",   "scenes",      "nodes",          "meshes",
      "accessors", "buffers", "bufferViews", "extensionsUsed", "extensionsRequired"};
  return std::find(std::begin(kNeeded), std::end(kNeeded), key) != std::end(kNeeded);
}

/// "syntax error while parsing ..." of nlohmann's message, which has its own number and place
/// ahead. It quotes what was read last, which may be long: then without the middle.
std::string reason_of(const json::exception& error) {
  constexpr std::size_t kHead = 120, kTail = 60;
  std::string text = error.what();
  if (const std::size_t at = text.find(": "); at != std::string::npos) text.erase(0, at + 2);
  if (text.size() > 2 * (kHead + kTail)) {
    text.replace(kHead, text.size() - kHead - kTail, " [...] ");
  }
  return text;
}

}  // namespace

GltfJson read_gltf_json(const RandomSource& source, std::uint64_t offset, std::uint64_t bytes) {
  GltfJson result;
  TextTaker taker(result);
  std::vector<char> piece(kPiece);
  for (std::uint64_t at = 0; at < bytes;) {
    const std::span<char> part = std::span(piece).first(
        static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, bytes - at)));
    source.read_at(offset + at, part);
    for (std::size_t i = 0; i < part.size(); ++i) taker.take(part[i], offset + at + i);
    at += part.size();
    if (taker.text().size() > kMostGltfJson) {
      source.fail_at_byte(offset, fmt::format("expected at most {} MiB of JSON without data, found "
                                              "more; join the nodes of the scene",
                                              kMostGltfJson >> 20));
    }
  }
  // Chunks of some writers end in zeros instead of blanks.
  std::string_view text = taker.text();
  while (text.ends_with('\0')) text.remove_suffix(1);
  const auto keep = [&](int depth, json::parse_event_t event, const json& parsed) {
    if (depth > kDeepest) {
      source.fail_at_byte(offset, fmt::format("expected JSON of at most {} levels", kDeepest));
    }
    return event != json::parse_event_t::key ||
           is_needed(depth, parsed.get_ref<const std::string&>());
  };
  try {
    result.root = json::parse(text.begin(), text.end(), keep);
  } catch (const json::parse_error& error) {
    const std::size_t at = error.byte > 0 ? error.byte - 1 : 0;
    source.fail_at_byte(offset + taker.offset_of(at),
                        fmt::format("expected glTF, which is JSON: {}", reason_of(error)));
  } catch (const json::exception& error) {
    source.fail_at_byte(offset, fmt::format("expected glTF, which is JSON: {}", reason_of(error)));
  }
  return result;
}

void GltfValue::fail(std::string_view what) const {
  throw InputError(
      fmt::format("{}: {}: {}", file_->string(), place_.empty() ? "glTF" : place_, what));
}

void GltfValue::fail_expected(std::string_view what) const {
  std::string found = json_->dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 40);
  fail(fmt::format("expected {}, found {}", what, found));
}

std::optional<GltfValue> GltfValue::find(std::string_view key) const {
  if (!json_->is_object()) fail_expected("an object");
  const auto at = json_->find(key);
  if (at == json_->end()) return std::nullopt;
  return GltfValue(*at, *file_,
                   place_.empty() ? std::string(key) : fmt::format("{}.{}", place_, key));
}

GltfValue GltfValue::require(std::string_view key) const {
  std::optional<GltfValue> member = find(key);
  if (!member) fail(fmt::format("expected {}, found none", key));
  return *std::move(member);
}

std::size_t GltfValue::size() const {
  if (!json_->is_array()) fail_expected("an array");
  return json_->size();
}

GltfValue GltfValue::item(std::size_t i) const {
  return {(*json_)[i], *file_, fmt::format("{}[{}]", place_, i)};
}

std::uint64_t GltfValue::count(std::string_view key, std::uint64_t otherwise) const {
  const std::optional<GltfValue> member = find(key);
  return member ? member->whole() : otherwise;
}

GltfValue GltfValue::element(const GltfValue& root, std::string_view array) const {
  const std::uint64_t index = whole();
  const std::optional<GltfValue> all = root.find(array);
  const std::size_t size = all ? all->size() : 0;
  if (index >= size)
    fail(fmt::format("expected an index into {} {}, found {}", size, array, index));
  return all->item(static_cast<std::size_t>(index));
}

std::uint64_t GltfValue::whole() const {
  if (json_->is_number_unsigned()) return json_->get<std::uint64_t>();
  // Some writers know one kind of number only: 3.0.
  const double value = json_->is_number() ? json_->get<double>() : -1;
  if (!(value >= 0 && value <= 0x1p53) || value != std::floor(value)) {
    fail_expected("a whole number from 0 to 2^53");
  }
  return static_cast<std::uint64_t>(value);
}

double GltfValue::number() const {
  if (!json_->is_number()) fail_expected("a number");
  return json_->get<double>();
}

std::string GltfValue::text() const {
  if (!json_->is_string()) fail_expected("a string");
  return json_->get<std::string>();
}

bool GltfValue::flag() const {
  if (!json_->is_boolean()) fail_expected("true or false");
  return json_->get<bool>();
}

}  // namespace remaps
