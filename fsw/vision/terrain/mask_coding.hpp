// Lossless coding of masks as bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Returns the largest size of a coded mask of `pixels` pixels, bytes.
[[nodiscard]] constexpr std::size_t max_mask_bytes(std::size_t pixels) {
  return 1 + (pixels + 7) / 8;
}

/// Codes a mask in the smallest of three forms. Pixels other than 0 are inside. The first byte names the form:
/// - 0: one bit per pixel, row by row, the lowest bit first; unused bits of the last byte are 0.
/// - 1: lengths of runs in raster order, alternately outside and inside, beginning with outside. Each length is a
///   LEB128 number: base-128 digits, lowest first, with the high bit set on all but the last.
/// - 2: pixels in raster order, coded arithmetically (bit_coder.hpp) in contexts of ten neighbours.
/// Returns `capacity_exceeded` if `capacity` is too small, `invalid_argument` if the mask is empty.
Status encode_mask(MaskView mask, std::uint8_t* bytes, std::size_t capacity, std::size_t& size);

/// Decodes a mask into `mask` (0 or 255), whose size the caller knows. Every byte is checked. Returns `truncated` if
/// bytes are missing, `parse_error` (a: offset) if they are malformed or too many, `invalid_argument` if the mask is
/// empty.
Status decode_mask(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask);

}  // namespace ilp
