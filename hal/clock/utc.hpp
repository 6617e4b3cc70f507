// Reads UTC from the board's calendar clock.
#pragma once

#include <cstdint>

namespace ilp {

/// Returns the nanoseconds of UTC since 1958-01-01 without leap seconds. The calendar clock may be wrong or jump, so
/// only start-up calls this function.
[[nodiscard]] std::int64_t utc_now();

}  // namespace ilp
