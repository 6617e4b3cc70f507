// Eight rows side by side in one vector, so that a recursion along a row is eight recursions without any exchange.
#pragma once

#include <cstdint>

#include "fsw/vision/stereo/cost/lanes.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"

namespace ilp {

using RowLanes = lanes::I16;
inline constexpr std::int32_t row_lanes = lanes::words;

/// Cost of a correlation of 0 or less; a correlation of 1 costs 0.
inline constexpr std::int16_t max_ordered_cost = 512;

/// Loads the costs of `count` matches of one column; `count` is a multiple of 8. `out[d]` receives those of eight rows.
/// `ncc[row]` are the row's correlations. A correlation of exactly 0 stands for a pixel out of view and costs
/// `unknown`.
void load_costs(const std::int16_t* const* ncc, std::ptrdiff_t entry, std::int32_t count, std::int16_t unknown,
                RowLanes* out);

}  // namespace ilp
