// Disparities at the edge of the view, where a part of the window shows no ground: resampling has filled it with the
// border's grey values.
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
  /// By row modulo the count: 1 where the whole window around the pixel is in view.
  std::array<Row, 2 * border_reach + 1> left_inner, right_inner;
  /// The right row's inner columns: the first ones without a gap, which are nearly always all there are.
  struct Span {
    std::int32_t begin = 0, end = 0;
    bool all = false;
  };
  std::array<Span, 2 * border_reach + 1> right_span;
  Row column;
};

/// Invalidates pixels of row `y` (sigma 0) whose window reaches out of the view of either image and whose disparity is
/// further than `params.border_step_px` from the median of the inner pixels within border_reach. Inner pixels are those
/// with the whole window in view; where there are none, the pixel stays. Rows come in the order y = 0 .. height - 1,
/// and the rows up to y + border_reach must be in place.
void check_border_row(MaskView left_valid, MaskView right_valid, const StereoParams& params, std::int32_t y,
                      ImageView<const float> disparity_px, const ImageView<float>& sigma_px,
                      BorderWorkspace& workspace);

}  // namespace ilp
