// From disparities of the rectified left image to inverse depth on the reference camera's own pixels (decisions.md, 8).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"
#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

/// Inverse depth along the reference camera's optical axis, 1 / unit of the world, on its real (distorted) pixel grid;
/// one sigma in the same unit, 0 for pixels without depth. Pixel x of a row whose disparity was supported, or
/// interpolated from one that was, has bit x % supported_bits of word x / supported_bits; without depth the bit says
/// nothing.
inline constexpr std::int32_t supported_bits = 64;
[[nodiscard]] constexpr std::int32_t supported_words(std::int32_t width) {
  return (width + supported_bits - 1) / supported_bits;
}
struct DepthView {
  ImageView<float> inverse_depth;
  ImageView<float> sigma;
  ImageView<std::uint64_t> supported;
};

/// Rows y_begin .. y_end - 1. With q = rect_from_left * (x, y, 1) for the pixel's normalised coordinates and
/// e = d - offset, homographies give
///   inverse depth = q_z e / (f b),  sigma = q_z sigma_d / (f b)
/// and polar coordinates, with rho = |(q_y, q_z)|, cot a = q_x / rho and the advance in the right image
/// r = asinh(cot a) - e / f,
///   inverse depth = rho (cot a - sinh r) / b,  sigma = rho cosh r sigma_d / (f b).
/// A polar pair writes only the pixels of its sector: clear `depth` before the first panel of a plan.
/// d is interpolated where its four neighbours are valid and differ by at most 1 px, else the nearest valid one is
/// taken. `invalid_argument`: output size is not the camera's, disparity size is not the pair's, rows of the map are
/// not equally far apart in its planes, rows outside.
Status depth_rows(const RectifiedPair& pair, const CameraModel& camera, const DisparityView& map, std::int32_t y_begin,
                  std::int32_t y_end, const DepthView& depth);

}  // namespace ilp
