// Mission time: nanoseconds since the mission epoch, and durations in the same unit.
#pragma once

#include <cstdint>

namespace ilp {

using TimeNs = std::int64_t;

inline constexpr TimeNs ns_per_us = 1'000;
inline constexpr TimeNs ns_per_ms = 1'000'000;
inline constexpr TimeNs ns_per_s = 1'000'000'000;

/// 126 years: the longest duration, and the latest mission time. The sum of two of them still fits into TimeNs.
inline constexpr TimeNs longest_duration_ns = 4'000'000'000 * ns_per_s;

/// Whole nanoseconds of a duration, cut towards zero. Longer durations become the longest one, and NaN becomes 0. This
/// is the only place where flight code converts seconds to nanoseconds.
[[nodiscard]] constexpr TimeNs ns_from_seconds(double seconds) {
  constexpr double longest_s = 1e-9 * static_cast<double>(longest_duration_ns);
  if (seconds >= longest_s) return longest_duration_ns;
  if (seconds <= -longest_s) return -longest_duration_ns;
  return seconds == seconds ? static_cast<TimeNs>(seconds * static_cast<double>(ns_per_s)) : 0;
}

[[nodiscard]] constexpr TimeNs distance(TimeNs a, TimeNs b) {
  return a < b ? b - a : a - b;
}

}  // namespace ilp
