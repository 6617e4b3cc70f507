// The disparity that a matcher chose for one pixel of a row.
#pragma once

#include <cstdint>

namespace ilp {

/// Cost of a pixel that the matcher leaves without a match.
inline constexpr std::int16_t occluded_cost = 32767;

/// Aligned, so that several are loaded as one vector.
struct alignas(8) RowWinner {
  std::int16_t cost = 0;   ///< path cost; if two left pixels chose the same right pixel, the cheaper one keeps it
  std::int16_t index = 0;  ///< disparity index; the smallest one if several cost the same
  bool unique = false;     ///< no other disparity, except the direct neighbours, is nearly as cheap
};

}  // namespace ilp
