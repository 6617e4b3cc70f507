#include "fsw/vision/stereo/ordered/slope_steps.hpp"

#include <algorithm>
#include <cstddef>

namespace ilp {

void match_slope_steps(std::int32_t width, std::int32_t padded, const std::int16_t* ncc, RowWinner* winners) {
  for (std::int32_t x = 1; x + 1 < width; ++x) {
    const RowWinner& before = winners[x - 1];
    const RowWinner& after = winners[x + 1];
    if (winners[x].cost != occluded_cost || before.cost == occluded_cost || after.cost == occluded_cost) continue;
    if (after.index != before.index + 1) continue;
    const std::int16_t* here = ncc + static_cast<std::ptrdiff_t>(x) * padded;
    winners[x] = here[after.index] > here[before.index] ? after : before;
    winners[x].unique = before.unique && after.unique;
  }
}

}  // namespace ilp
