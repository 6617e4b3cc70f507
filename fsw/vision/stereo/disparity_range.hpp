// Range of the disparities of a rectified pair. Rectification plans it; the matcher searches it.
#pragma once

#include <cstdint>

namespace ilp {

/// Disparities d = x_left - x_right in whole rectified pixels, from min_px to max_px inclusive.
struct DisparityRange {
  std::int32_t min_px = 0;
  std::int32_t max_px = 63;

  [[nodiscard]] std::int32_t count() const { return max_px - min_px + 1; }
};

}  // namespace ilp
