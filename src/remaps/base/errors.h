#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace remaps {

/// Base of everything remaps throws. The message names the file, the place and what was expected.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input is unreadable or malformed (exit 3). The message ends in byte offset, line or element.
class InputError : public Error {
 public:
  using Error::Error;
};

/// The file system failed: open, read, write, rename (exit 3 for inputs, 5 for a full disk).
class IoError : public Error {
 public:
  using Error::Error;
};

/// The surface is well-formed data but not of a kind that can be handled (exit 4).
class GeometryError : public Error {
 public:
  using Error::Error;
};

/// The stated memory or disk budget cannot do the job (exit 5). Says the least that would.
class BudgetError : public Error {
 public:
  using Error::Error;
};

/// A sealed file of ours fails its checksum or its own rules (exit 6).
class CorruptionError : public Error {
 public:
  using Error::Error;
};

/// The user asked to stop (exit 130).
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

/// Converts between integer types; throws std::range_error when the value does not fit.
template <class To, class From>
constexpr To narrow(From value) {
  const To result = static_cast<To>(value);
  if (!std::in_range<To>(value)) throw std::range_error("integer does not fit its narrower type");
  return result;
}

}  // namespace remaps
