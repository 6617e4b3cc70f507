// UTC, if the board has it.
#pragma once

#include <cstdint>

namespace ilp {

/// Nanoseconds of UTC since 1958-01-01 without leap seconds, by the board's calendar clock. It may be set or jump, so
/// it is for start-up only.
[[nodiscard]] std::int64_t utc_now();

}  // namespace ilp
