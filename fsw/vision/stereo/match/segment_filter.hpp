// Removes small isolated segments of a disparity map, row by row.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/match/pixel_forest.hpp"

namespace ilp {

/// Joins pixels of row `y` to their left and upper neighbours if both are valid (sigma > 0) and their disparities
/// differ by at most `max_step_px`. Rows must come in order.
void connect_segments_row(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t y,
                          float max_step_px, PixelForest& workspace);

/// Sets sigma to 0 in row `y` where the segment has fewer than `min_area_px` pixels. Call it after all rows are
/// connected.
void remove_small_segments_row(ImageView<float> sigma_px, std::int32_t y, std::int32_t min_area_px,
                               PixelForest& workspace);

}  // namespace ilp
