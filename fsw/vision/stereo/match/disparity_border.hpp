// Checks disparities at the edge of the view. A part of the window there shows no ground, because resampling has filled
// it with the grey values of the border.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// Distance within which a pixel's inner neighbours are searched, px.
inline constexpr std::int32_t border_reach = 4;

struct BorderWorkspace {
  using Row = std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)>;
  /// Ring of rows, indexed by row modulo the number of rows: 1 if the whole window around the pixel is in view.
  std::array<Row, 2 * border_reach + 1> left_inner, right_inner;
  /// Inner columns of a right row: the first contiguous span of them. `all`: there are no others, which is nearly
  /// always so.
  struct Span {
    std::int32_t begin = 0, end = 0;
    bool all = false;
  };
  std::array<Span, 2 * border_reach + 1> right_span;
  Row column;
};

/// Checks row `y`. A pixel is an inner pixel if its whole window is in view in both images. A pixel that is not an
/// inner one is invalidated (sigma 0) if its disparity differs by more than `params.border_step_px` from the median of
/// the inner pixels within border_reach; without such inner pixels it stays. Rows must be checked in the order y = 0 ..
/// height - 1, and the rows up to y + border_reach must be complete.
void check_border_row(MaskView left_valid, MaskView right_valid, const StereoParams& params, std::int32_t y,
                      ImageView<const float> disparity_px, const ImageView<float>& sigma_px,
                      BorderWorkspace& workspace);

}  // namespace ilp
