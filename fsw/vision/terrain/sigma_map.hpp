// The errors of a depth map in few bytes: one printable character per block of pixels, for the metadata of a product.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"

namespace ilp {

/// Errors are coded in 1/64 px of disparity; 0 is no depth, 127 "or more". The highest bit says that the ground around
/// the pixel supports its depth.
inline constexpr double sigma_codes_per_px = 64;
inline constexpr std::uint8_t sigma_code_largest = 127, sigma_code_supported = 128;
inline constexpr std::int32_t sigma_block_px = 32;
/// Codes of the errors of inverse depths, rounded up, pixel by pixel; `codes` holds as many as there are errors. An
/// inverse depth that changes by one moves its disparity by `disparity_per_inverse_depth_px`. Returns the number of
/// supported depths.
std::uint32_t code_sigma(const DepthView& depth, double disparity_per_inverse_depth_px, std::uint8_t* codes);

/// '!' stands for a block without depth; the n-th character after it for a sigma of 2^((n - 1) / 8) codes, so that a
/// character is at most 9 % more than what it stands for.
inline constexpr char sigma_map_none = '!';
inline constexpr int sigma_map_levels = 65;

[[nodiscard]] constexpr std::int32_t sigma_map_side(std::int32_t side_px) {
  return (side_px + sigma_block_px - 1) / sigma_block_px;
}
inline constexpr std::size_t max_sigma_map_bytes = static_cast<std::size_t>(sigma_map_side(limits::max_image_width)) *
                                                   static_cast<std::size_t>(sigma_map_side(limits::max_image_height));

/// Blocks come row by row; a block stands for the median code of its pixels that lie in the mask and have a code.
/// `size` characters are written. `invalid_argument`: mask of another size; `capacity_exceeded`.
Status encode_sigma_map(ImageView<const std::uint8_t> codes, MaskView mask, std::span<char> out, std::size_t& size);

/// The error in codes; 0 for a block without depth and for any other character.
[[nodiscard]] double sigma_of_character(char character);

}  // namespace ilp
