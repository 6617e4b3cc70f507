// Lossless coding of masks as bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// The largest size of a coded mask of `pixels`.
[[nodiscard]] constexpr std::size_t max_mask_bytes(std::size_t pixels) {
  return 1 + (pixels + 7) / 8;
}

/// Writes the smallest of three forms, named by the first byte: 0 = one bit per pixel, row by row, the lowest bit
/// first, the last byte filled with zeros; 1 = lengths of runs in raster order, outside and inside alternately from
/// outside, each as base-128 digits with the lowest first and the high bit on all but the last (LEB128); 2 = pixels in
/// raster order, coded arithmetically (bit_coder.hpp) in contexts of ten neighbours. Pixels other than 0 are inside.
/// `capacity_exceeded` when `capacity` is too small.
Status encode_mask(MaskView mask, std::uint8_t* bytes, std::size_t capacity, std::size_t& size);

/// Fills `mask` (0 or 255), whose size the caller knows. Every byte is checked: `truncated`, `parse_error` (a =
/// offset).
Status decode_mask(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask);

}  // namespace ilp
