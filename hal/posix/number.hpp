// Reads decimal numbers from arbitrary text.
#pragma once

#include <cstdint>

namespace ilp {

/// Reads digits at `text` and moves past them. Returns false, with `text` somewhere among them, when there is none or
/// more than `max_digits` (at most 18).
[[nodiscard]] inline bool read_digits(const char*& text, int max_digits, std::int64_t& value) {
  value = 0;
  int digits = 0;
  for (; *text >= '0' && *text <= '9' && digits <= max_digits; ++text, ++digits) value = value * 10 + (*text - '0');
  return digits > 0 && digits <= max_digits;
}

}  // namespace ilp
