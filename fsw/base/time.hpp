// Mission time: nanoseconds since the mission epoch, and durations in the same unit.
#pragma once

#include <cstdint>

namespace ilp {

using TimeNs = std::int64_t;

inline constexpr TimeNs ns_per_us = 1'000;
inline constexpr TimeNs ns_per_ms = 1'000'000;
inline constexpr TimeNs ns_per_s = 1'000'000'000;

/// Whole nanoseconds of a duration, cut towards zero. |seconds| < 9e9.
[[nodiscard]] constexpr TimeNs ns_from_seconds(double seconds) {
  return static_cast<TimeNs>(seconds * static_cast<double>(ns_per_s));
}

[[nodiscard]] constexpr TimeNs distance(TimeNs a, TimeNs b) {
  return a < b ? b - a : a - b;
}

}  // namespace ilp
