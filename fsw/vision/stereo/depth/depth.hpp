// Converts disparities of the rectified left image to inverse depth on the pixel grid of the reference camera
// (decisions.md, 8).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"
#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

/// A map of inverse depth along the reference camera's optical axis, 1 / world unit, on the pixel grid of the real
/// (distorted) image. `sigma` is the one-sigma error in the same unit, 0 for pixels without depth. `supported` has one
/// bit per pixel: bit x % supported_bits of word x / supported_bits is set if the disparity of pixel x was supported
/// (DisparityKind), or interpolated from a supported one. For pixels without depth the bit has no meaning.
inline constexpr std::int32_t supported_bits = 64;
[[nodiscard]] constexpr std::int32_t supported_words(std::int32_t width) {
  return (width + supported_bits - 1) / supported_bits;
}
struct DepthView {
  ImageView<float> inverse_depth;
  ImageView<float> sigma;
  ImageView<std::uint64_t> supported;
};

/// Computes rows y_begin .. y_end - 1 of `depth`. Let q = rect_from_left * (x, y, 1) for a pixel's normalised
/// coordinates (x, y), and e = d - offset for its disparity d. For a pair rectified by homographies,
///   inverse depth = q_z e / (f b),  sigma = q_z sigma_d / (f b).
/// For polar coordinates, let rho = |(q_y, q_z)|, cot a = q_x / rho, and let r = asinh(cot a) - e / f be the advance in
/// the right image. Then
///   inverse depth = rho (cot a - sinh r) / b,  sigma = rho cosh r sigma_d / (f b).
/// A polar pair writes only the pixels of its sector: clear `depth` before the first panel of a plan. d is interpolated
/// if its four neighbours are valid and differ by at most 1 px; otherwise d is that of the nearest neighbour, and a
/// pixel whose nearest neighbour is invalid gets no depth. Returns `invalid_argument` if the output does not have the
/// size of the camera, if the map does not have the size of the pair, if the planes of the map differ in row stride, or
/// if the rows are outside the image.
Status depth_rows(const RectifiedPair& pair, const CameraModel& camera, const DisparityView& map, std::int32_t y_begin,
                  std::int32_t y_end, const DepthView& depth);

}  // namespace ilp
