// The answer of a matcher for one pixel of a row.
#pragma once

#include <cstdint>

namespace ilp {

/// The cost of a pixel that the matcher leaves without a match.
inline constexpr std::int16_t occluded_cost = 32767;

/// Aligned, so that several are loaded as one vector.
struct alignas(8) RowWinner {
  std::int16_t cost = 0;   ///< of two left pixels that chose one right pixel the cheaper one keeps it
  std::int16_t index = 0;  ///< of the disparity, the smallest of several that are equally good
  bool unique = false;     ///< no disparity but its direct neighbours is nearly as good
};

}  // namespace ilp
