// Measures how much the pixels of one surface differ from their counterparts in the other image.
#pragma once

#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"

namespace ilp {

/// Disparities are in quarters of a pixel, grey values in quarters of a grey level.
inline constexpr std::int32_t quarters_per_px = 4;
/// Radius of the patch of 7 x 7 pixels.
inline constexpr std::int32_t patch_radius = 3;
/// Differences of two counterparts are clamped to this value: a larger one only says that they are not the same.
inline constexpr std::int32_t most_difference = 20 * quarters_per_px;

/// Rounds a disparity from quarters to whole pixels.
[[nodiscard]] constexpr std::int32_t whole_px(std::int32_t quarter_px) {
  return (quarter_px + quarters_per_px / 2) >> 2;
}

/// Returns true if the right image contains the counterparts of the whole patch around (x, y).
[[nodiscard]] bool sees_patch(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t quarter_px);

/// Returns the weighted mean difference between the pixels near (x, y) and their counterparts at disparity
/// `quarter_px`, 0 to most_difference. `brightness` is the grey difference that counterparts have everywhere; it is
/// subtracted. The weight of a pixel says how similar it is to (x, y), and its counterpart to that of (x, y); it is 0
/// from 50 grey levels on. The left image must contain the patch and one more column to its right, and the right image
/// must contain its counterparts (sees_patch). Of `rows`, only the images are read.
[[nodiscard]] float patch_difference(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t quarter_px,
                                     std::int32_t brightness);

}  // namespace ilp
