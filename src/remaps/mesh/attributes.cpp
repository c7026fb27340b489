#include "remaps/mesh/attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::array<std::string_view, 10> kTypeNames = {
    "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"};
constexpr std::array<std::string_view, 5> kKindNames = {"colour", "normal", "uv", "scalar",
                                                        "label"};
constexpr std::array<std::string_view, 3> kPerNames = {"vertex", "face", "corner"};

template <class Enum, std::size_t kSize>
std::optional<Enum> named(const std::array<std::string_view, kSize>& names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<Enum>(at - names.begin());
}

/// Calls f with a value of the type.
template <class F>
auto with_type(ScalarType type, F f) {
  switch (type) {
    case ScalarType::int8:
      return f(std::int8_t{});
    case ScalarType::uint8:
      return f(std::uint8_t{});
    case ScalarType::int16:
      return f(std::int16_t{});
    case ScalarType::uint16:
      return f(std::uint16_t{});
    case ScalarType::int32:
      return f(std::int32_t{});
    case ScalarType::uint32:
      return f(std::uint32_t{});
    case ScalarType::int64:
      return f(std::int64_t{});
    case ScalarType::uint64:
      return f(std::uint64_t{});
    case ScalarType::float32:
      return f(float{});
    default:
      return f(double{});
  }
}

template <class T>
T rounded(double value) {
  if constexpr (std::is_integral_v<T>) {
    if (std::isnan(value)) return 0;
    const double whole = std::round(value);
    // The largest 64-bit integers are no doubles: what reaches them is kept at them.
    if (whole >= static_cast<double>(std::numeric_limits<T>::max())) {
      return std::numeric_limits<T>::max();
    }
    if (whole <= static_cast<double>(std::numeric_limits<T>::min())) {
      return std::numeric_limits<T>::min();
    }
    return static_cast<T>(whole);
  } else if constexpr (std::is_same_v<T, float>) {
    constexpr double kMost = static_cast<double>(std::numeric_limits<float>::max());
    if (std::isfinite(value)) value = std::clamp(value, -kMost, kMost);
    return static_cast<float>(value);
  } else {
    return value;
  }
}

}  // namespace

std::size_t size_of(ScalarType type) {
  return with_type(type, [](auto value) { return sizeof value; });
}

double full_colour(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
      return std::numeric_limits<std::int8_t>::max();
    case ScalarType::uint8:
      return std::numeric_limits<std::uint8_t>::max();
    case ScalarType::int16:
      return std::numeric_limits<std::int16_t>::max();
    case ScalarType::uint16:
      return std::numeric_limits<std::uint16_t>::max();
    case ScalarType::int32:
      return std::numeric_limits<std::int32_t>::max();
    case ScalarType::uint32:
      return std::numeric_limits<std::uint32_t>::max();
    case ScalarType::int64:
      return static_cast<double>(std::numeric_limits<std::int64_t>::max());
    case ScalarType::uint64:
      return static_cast<double>(std::numeric_limits<std::uint64_t>::max());
    default:
      return 1;
  }
}

std::string_view name_of(ScalarType type) {
  return kTypeNames[static_cast<std::size_t>(type)];
}
std::optional<ScalarType> scalar_type_named(std::string_view name) {
  return named<ScalarType>(kTypeNames, name);
}
std::string_view name_of(AttributeKind kind) {
  return kKindNames[static_cast<std::size_t>(kind)];
}
std::optional<AttributeKind> attribute_kind_named(std::string_view name) {
  return named<AttributeKind>(kKindNames, name);
}
std::string_view name_of(AttributePer per) {
  return kPerNames[static_cast<std::size_t>(per)];
}
std::optional<AttributePer> attribute_per_named(std::string_view name) {
  return named<AttributePer>(kPerNames, name);
}

std::size_t row_bytes(const AttributeSpec& spec) {
  std::size_t bytes = 0;
  for (const AttributeComponent& c : spec.components) bytes += size_of(c.type);
  return bytes;
}

std::size_t row_bytes(std::span<const AttributeSpec> specs, AttributePer per) {
  std::size_t bytes = 0;
  for (const AttributeSpec& spec : specs) bytes += spec.per == per ? row_bytes(spec) : 0;
  return bytes;
}

std::size_t channels(std::span<const AttributeSpec> specs, AttributePer per) {
  std::size_t count = 0;
  for (const AttributeSpec& spec : specs) count += spec.per == per ? spec.components.size() : 0;
  return count;
}

std::vector<AttributeSpec> attributes_per(std::span<const AttributeSpec> specs, AttributePer per) {
  std::vector<AttributeSpec> result;
  std::copy_if(specs.begin(), specs.end(), std::back_inserter(result),
               [per](const AttributeSpec& spec) { return spec.per == per; });
  return result;
}

double load_scalar(ScalarType type, const std::byte* from) {
  return with_type(type, [from](auto value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(value);
  });
}

void store_scalar(ScalarType type, double value, std::byte* to) {
  with_type(type, [to, value](auto example) {
    const auto stored = rounded<decltype(example)>(value);
    std::memcpy(to, &stored, sizeof stored);
    return 0;
  });
}

void pack_row(std::span<const AttributeSpec> specs, std::span<const double> values,
              std::span<std::byte> row) {
  std::size_t at = 0, channel = 0;
  for (const AttributeSpec& spec : specs) {
    for (const AttributeComponent& c : spec.components) {
      store_scalar(c.type, values[channel++], row.data() + at);
      at += size_of(c.type);
    }
  }
}

void unpack_row(std::span<const AttributeSpec> specs, std::span<const std::byte> row,
                std::span<double> values) {
  std::size_t at = 0, channel = 0;
  for (const AttributeSpec& spec : specs) {
    for (const AttributeComponent& c : spec.components) {
      values[channel++] = load_scalar(c.type, row.data() + at);
      at += size_of(c.type);
    }
  }
}

AttributeChoice::AttributeChoice(std::string_view text) : all_(text == "all") {
  if (all_ || text == "none") return;
  for (;;) {
    const std::size_t end = std::min(text.find(','), text.size());
    if (end == 0)
      throw InputError("expected all, none or names of attributes, found an empty name");
    names_.emplace_back(text.substr(0, end));
    if (end == text.size()) return;
    text.remove_prefix(end + 1);
  }
}

std::vector<AttributeSpec> AttributeChoice::choose(std::span<const AttributeSpec> specs,
                                                   std::string_view file) const {
  if (all_) return {specs.begin(), specs.end()};
  for (const std::string& name : names_) {
    if (std::any_of(specs.begin(), specs.end(), [&](const auto& s) { return s.name == name; }))
      continue;
    std::string there;
    for (const AttributeSpec& spec : specs) there += (there.empty() ? "" : ", ") + spec.name;
    throw InputError(fmt::format("{}: has no attribute '{}'; {}", file, name.substr(0, 80),
                                 there.empty() ? "it has none at all" : "there are " + there));
  }
  std::vector<AttributeSpec> chosen;
  std::copy_if(specs.begin(), specs.end(), std::back_inserter(chosen), [&](const auto& spec) {
    return std::find(names_.begin(), names_.end(), spec.name) != names_.end();
  });
  return chosen;
}

}  // namespace remaps
