// Fills in the left pixels that an ordered path leaves unmatched on slanted ground.
#pragma once

#include <cstdint>

#include "fsw/vision/stereo/cost/row_winner.hpp"

namespace ilp {

/// Matches skipped pixels in columns 1 to width - 2 of a row. Where the disparity of slanted ground grows by one, the
/// path skips one left pixel, which is not occluded but foreshortened in the right image. Such a pixel takes the one of
/// the two adjacent disparities that correlates better. `ncc` is the result of compute_ncc_row.
void match_slope_steps(std::int32_t width, std::int32_t padded, const std::int16_t* ncc, RowWinner* winners);

}  // namespace ilp
