#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace remaps::cli {

/// "1,234,567".
std::string with_commas(std::uint64_t n);

/// "1 face", "1,234 faces".
std::string counted(std::uint64_t n, std::string_view noun);

/// "212 MiB".
std::string bytes_text(std::uint64_t bytes);

/// "0.42 s", "12.3 s", "3m05s", "2h07m".
std::string seconds_text(double seconds);

/// "0:07", "12:34", "1:02:03": whole seconds, for the progress bar.
std::string clock_text(double seconds);

/// A fraction of the bounding-box diagonal, in the unit that errors are compared in: "0.72e-4".
std::string error_text(double fraction);

/// "82.9 dB", or "exact" for no error.
std::string psnr_text(double l2);

/// 20 log10(diagonal / L2), in dB; nothing for no error.
std::optional<double> psnr(double l2);

/// Reads a number of bytes: "268435456", "256M", "1.5G"; K, M, G, T are powers of 1024, in any
/// case. Nothing if the text is anything else or the size beyond 2^63.
std::optional<std::uint64_t> parse_bytes(std::string_view text);

/// Reads a count: "200", "1.5k", "20M", "1G"; k, M, G are powers of 1000, in any case.
std::optional<std::uint64_t> parse_count(std::string_view text);

/// Reads all of a text as one number.
std::optional<std::uint64_t> parse_integer(std::string_view text);
std::optional<double> parse_real(std::string_view text);

}  // namespace remaps::cli
