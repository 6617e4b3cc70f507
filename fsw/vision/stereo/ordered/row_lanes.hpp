// Eight rows side by side in one vector, so that a recursion along a row is eight recursions without any exchange.
#pragma once

#include <cstdint>

#include "fsw/vision/stereo/cost/lanes.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"

namespace ilp {

using RowLanes = lanes::I16;
inline constexpr std::int32_t row_lanes = lanes::words;

/// A correlation of 1 costs nothing, a correlation of 0 or less costs this.
inline constexpr std::int16_t max_ordered_cost = 512;

/// Costs of `count` matches of one column, a multiple of 8: `out[d]` has those of eight rows. `ncc[row]` are the row's
/// correlations; 0, that of a pixel out of view, costs `unknown`.
void load_costs(const std::int16_t* const* ncc, std::ptrdiff_t entry, std::int32_t count, std::int16_t unknown,
                RowLanes* out);

}  // namespace ilp
