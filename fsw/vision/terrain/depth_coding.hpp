// Inverse depth as integers in equal steps of disparity, so that the error of coding is known beforehand (decisions.md,
// 8).
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr int depth_code_bits = 13;
inline constexpr std::int32_t max_depth_code = (1 << depth_code_bits) - 1;

/// inverse depth = offset + step * code for codes 1 .. max_depth_code; code 0 is invalid.
struct DepthCoding {
  double offset = 0;
  double step = 0;
};

/// Finds the coding for the pixels inside `mask` with sigma > 0. The step is 1 / (steps_per_px * focal_px * baseline),
/// doubled until the codes suffice; the offset is a multiple of the step. Without such pixels the codes start at 0.
/// `invalid_argument`: sizes, focal length, baseline or steps not positive.
Status choose_depth_coding(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                           double focal_px, double baseline, double steps_per_px, DepthCoding& coding);

/// Codes the pixels inside `mask` with sigma > 0, and 0 elsewhere; the error is at most step / 2. `capacity_exceeded`
/// when a pixel lies outside the codes (a coding of other pixels), `invalid_argument` for sizes, for the
/// coding.
Status encode_depth(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                    const DepthCoding& coding, const ImageView<std::uint16_t>& codes);

/// Decodes; 0 where the code is invalid. `parse_error` (a = pixel index) for a code above the largest.
Status decode_depth(ImageView<const std::uint16_t> codes, const DepthCoding& coding,
                    const ImageView<float>& inverse_depth);

}  // namespace ilp
