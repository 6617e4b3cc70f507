// Slanted ground in the path of a scanline.
#pragma once

#include <cstdint>

#include "fsw/vision/stereo/cost/row_winner.hpp"

namespace ilp {

/// Where the disparity of slanted ground grows by one, the path leaves one left pixel out, which is not occluded but
/// foreshortened in the right image. Such a pixel takes the one of both disparities that correlates better.
/// Columns 1 to width - 2; `ncc` is that of compute_ncc_row.
void match_slope_steps(std::int32_t width, std::int32_t padded, const std::int16_t* ncc, RowWinner* winners);

}  // namespace ilp
