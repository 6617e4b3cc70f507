// The disparities that a rectified pair can have: rectification plans them and the matcher searches them.
#pragma once

#include <cstdint>

namespace ilp {

/// Disparity d = x_left - x_right, in whole rectified pixels; both ends are searched.
struct DisparityRange {
  std::int32_t min_px = 0;
  std::int32_t max_px = 63;

  [[nodiscard]] std::int32_t count() const { return max_px - min_px + 1; }
};

}  // namespace ilp
