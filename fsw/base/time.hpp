// Mission time: nanoseconds since the mission epoch, and durations in the same unit.
#pragma once

#include <cstdint>

namespace ilp {

using TimeNs = std::int64_t;

inline constexpr TimeNs ns_per_us = 1'000;
inline constexpr TimeNs ns_per_ms = 1'000'000;
inline constexpr TimeNs ns_per_s = 1'000'000'000;

/// The longest duration and the latest mission time, 126 years. The sum of two such values still fits into TimeNs.
inline constexpr TimeNs longest_duration_ns = 4'000'000'000 * ns_per_s;

/// Converts seconds to nanoseconds, truncated towards zero. The result is clamped to +-longest_duration_ns, and NaN
/// gives 0. All conversions from seconds to nanoseconds in flight code call this function.
[[nodiscard]] constexpr TimeNs ns_from_seconds(double seconds) {
  constexpr double longest_s = 1e-9 * static_cast<double>(longest_duration_ns);
  if (seconds >= longest_s) return longest_duration_ns;
  if (seconds <= -longest_s) return -longest_duration_ns;
  return seconds == seconds ? static_cast<TimeNs>(seconds * static_cast<double>(ns_per_s)) : 0;
}

/// Absolute difference.
[[nodiscard]] constexpr TimeNs distance(TimeNs a, TimeNs b) {
  return a < b ? b - a : a - b;
}

}  // namespace ilp
