// Codes the errors of a depth map in few bytes for the metadata of a product: one printable character per block of
// pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"

namespace ilp {

/// Errors are coded in units of 1/64 px of disparity. Code 0 means no depth, code 127 "or more". The highest bit is set
/// if the depth of the pixel is supported by the ground around it (DisparityKind).
inline constexpr double sigma_codes_per_px = 64;
inline constexpr std::uint8_t sigma_code_largest = 127, sigma_code_supported = 128;
inline constexpr std::int32_t sigma_block_px = 32;
/// Codes the sigma of each inverse depth, rounded up; `codes` has one element per pixel. A change of the inverse depth
/// by 1 changes the disparity by `disparity_per_inverse_depth_px`. Returns the number of supported depths.
std::uint32_t code_sigma(const DepthView& depth, double disparity_per_inverse_depth_px, std::uint8_t* codes);

/// The character '!' stands for a block without depth. The n-th character after it stands for a sigma of 2^((n - 1) /
/// 8) code units, rounded up, which is at most 9 % too large.
inline constexpr char sigma_map_none = '!';
inline constexpr int sigma_map_levels = 65;

[[nodiscard]] constexpr std::int32_t sigma_map_side(std::int32_t side_px) {
  return (side_px + sigma_block_px - 1) / sigma_block_px;
}
inline constexpr std::size_t max_sigma_map_bytes = static_cast<std::size_t>(sigma_map_side(limits::max_image_width)) *
                                                   static_cast<std::size_t>(sigma_map_side(limits::max_image_height));

/// Writes one character per block, row by row: that of the median code of its pixels that lie in the mask and have a
/// code. `size` is the number of characters. Returns `invalid_argument` if the mask has another size,
/// `capacity_exceeded` if `out` is too small.
Status encode_sigma_map(ImageView<const std::uint8_t> codes, MaskView mask, std::span<char> out, std::size_t& size);

/// Returns the sigma of a character in code units; 0 for a block without depth and for any other character.
[[nodiscard]] double sigma_of_character(char character);

}  // namespace ilp
