#include "number_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace remaps::cli {
namespace {

template <class T>
std::optional<T> parse_whole(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// A number with an optional suffix, the i-th of which stands for kilo^(i + 1).
std::optional<std::uint64_t> parse_scaled(std::string_view text, std::string_view suffixes,
                                          double kilo) {
  double scale = 1;
  if (!text.empty()) {
    const char last = text.back() >= 'a' ? static_cast<char>(text.back() - 'a' + 'A') : text.back();
    const std::size_t power = suffixes.find(last);
    if (power != std::string_view::npos) {
      scale = std::pow(kilo, static_cast<double>(power + 1));
      text.remove_suffix(1);
    }
  }
  if (const auto whole = parse_integer(text); whole && scale == 1) return whole;
  const auto number = parse_real(text);
  if (!number || scale == 1) return std::nullopt;
  const double scaled = std::round(*number * scale);
  if (!(scaled >= 0 && scaled < 0x1p63)) return std::nullopt;
  return static_cast<std::uint64_t>(scaled);
}

}  // namespace

std::string with_commas(std::uint64_t n) {
  std::string text = std::to_string(n);
  for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
  return text;
}

std::string counted(std::uint64_t n, std::string_view noun) {
  if (n == 1) return fmt::format("1 {}", noun);
  return noun.ends_with("vertex")
             ? fmt::format("{} {}ices", with_commas(n), noun.substr(0, noun.size() - 2))
             : fmt::format("{} {}s", with_commas(n), noun);
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr const char* kUnits[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1024 && unit + 1 < std::size(kUnits); ++unit) value /= 1024;
  return fmt::format("{:.{}f} {}", value, unit == 0 || value >= 99.95 ? 0 : 1, kUnits[unit]);
}

std::string seconds_text(double seconds) {
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{}m{:02}s", whole / 60, whole % 60);
  return fmt::format("{}h{:02}m", whole / 3600, whole / 60 % 60);
}

std::string clock_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(seconds);
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string error_text(double fraction) {
  if (fraction == 0) return "0";
  const double scaled = fraction * 1e4;
  if (scaled < 0.00995) return fmt::format("{:.1e}", fraction);
  return fmt::format("{:.{}f}e-4", scaled, scaled < 9.995 ? 2 : scaled < 99.95 ? 1 : 0);
}

std::optional<double> psnr(double l2) {
  if (!(l2 > 0)) return std::nullopt;
  return 20 * std::log10(1 / l2);
}

std::string psnr_text(double l2) {
  const auto decibels = psnr(l2);
  return decibels ? fmt::format("{:.1f} dB", *decibels) : "exact";
}

std::optional<std::uint64_t> parse_bytes(std::string_view text) {
  return parse_scaled(text, "KMGT", 1024);
}

std::optional<std::uint64_t> parse_count(std::string_view text) {
  return parse_scaled(text, "KMG", 1000);
}

std::optional<std::uint64_t> parse_integer(std::string_view text) {
  return parse_whole<std::uint64_t>(text);
}

std::optional<double> parse_real(std::string_view text) {
  const auto value = parse_whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace remaps::cli
