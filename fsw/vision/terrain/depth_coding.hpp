// Quantises inverse depth in equal steps of disparity, so that the coding error is known in advance (decisions.md, 8).
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr int depth_code_bits = 13;
inline constexpr std::int32_t max_depth_code = (1 << depth_code_bits) - 1;

/// For codes 1 .. max_depth_code, inverse depth = offset + step * code. Code 0 means no depth.
struct DepthCoding {
  double offset = 0;
  double step = 0;
};

/// Chooses the coding for the pixels inside `mask` with sigma > 0. The step is 1 / (steps_per_px * focal_px *
/// baseline), doubled until the codes cover the range. The offset is a multiple of the step. Without such pixels the
/// coding starts at an inverse depth of 0. Returns `invalid_argument` if sizes differ, or if focal length, baseline or
/// steps are not positive.
Status choose_depth_coding(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                           double focal_px, double baseline, double steps_per_px, DepthCoding& coding);

/// Writes the codes of the pixels inside `mask` with sigma > 0, and 0 for other pixels. The quantisation error is at
/// most step / 2. Returns `capacity_exceeded` if a pixel lies outside the range of the codes because `coding` was
/// chosen for other pixels, `invalid_argument` if sizes differ or the coding is not valid.
Status encode_depth(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                    const DepthCoding& coding, const ImageView<std::uint16_t>& codes);

/// Converts codes to inverse depth, 0 for code 0. Returns `parse_error` (a = pixel index) if a code exceeds
/// max_depth_code, `invalid_argument` if sizes differ or the coding is not valid.
Status decode_depth(ImageView<const std::uint16_t> codes, const DepthCoding& coding,
                    const ImageView<float>& inverse_depth);

}  // namespace ilp
