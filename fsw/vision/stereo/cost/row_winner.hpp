// The answer of a matcher for one pixel of a row.
#pragma once

#include <cstdint>

namespace ilp {

/// The disparity index that the matcher chose, the smallest of several equal ones.
inline constexpr std::int16_t occluded_cost = 32767;

struct RowWinner {
  std::int16_t cost = 0;  ///< of two left pixels that chose one right pixel the cheaper one keeps it
  std::int16_t index = 0;
  bool unique = false;  ///< no index other than its direct neighbours costs less than `lead` more
};

}  // namespace ilp
