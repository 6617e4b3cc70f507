// Reads decimal numbers from untrusted text.
#pragma once

#include <cstdint>

namespace ilp {

/// Reads a number of 1 to `max_digits` (at most 18) digits at `text` and moves `text` past it. Returns false if there
/// is no digit or there are more; `text` then points at or among the digits.
[[nodiscard]] inline bool read_digits(const char*& text, int max_digits, std::int64_t& value) {
  value = 0;
  int digits = 0;
  for (; *text >= '0' && *text <= '9' && digits <= max_digits; ++text, ++digits) value = value * 10 + (*text - '0');
  return digits > 0 && digits <= max_digits;
}

}  // namespace ilp
