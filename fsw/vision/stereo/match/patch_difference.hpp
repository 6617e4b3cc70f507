// How much the pixels of one surface differ from their counterparts in the other image.
#pragma once

#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"

namespace ilp {

/// Disparities and grey values are in quarters here.
inline constexpr std::int32_t quarters_per_px = 4;
/// Of the patch of 7 x 7 pixels.
inline constexpr std::int32_t patch_radius = 3;
/// A larger difference of two counterparts says no more than that they are not the same.
inline constexpr std::int32_t most_difference = 20 * quarters_per_px;

/// The distance in whole pixels that is nearest to a disparity.
[[nodiscard]] constexpr std::int32_t whole_px(std::int32_t quarter_px) {
  return (quarter_px + quarters_per_px / 2) >> 2;
}

/// Whether the right image shows the counterparts of a whole patch.
[[nodiscard]] bool sees_patch(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t quarter_px);

/// Mean difference between the pixels near (x, y) and their counterparts, 0 to most_difference. `brightness` is the
/// part that counterparts differ by everywhere. A pixel counts by how much it looks like (x, y), and its counterpart
/// like that of (x, y); one that differs by 50 grey levels or more does not count. The left image must have the patch
/// and one column more on its right, and the right image must see it. Only the images of `rows` are read.
[[nodiscard]] float patch_difference(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t quarter_px,
                                     std::int32_t brightness);

}  // namespace ilp
