// Pixel formats of V4L2 and their conversion to 8 bits of grey.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// A pixel takes `bytes` bytes. Its grey value is the little-endian number in them, for YUYV the first of them:
/// - 8 bits: the byte itself; for YUYV the luma as it is, in whatever range the camera uses.
/// - 10, 12, 16 bits: the value divided by 2^(bits - 8), rounded down. A value beyond its bits becomes 255.
struct PixelFormat {
  std::uint32_t fourcc;  ///< V4L2_PIX_FMT_...
  const char* name;
  std::uint8_t bytes;
  std::uint8_t bits;
};

/// In the order of preference.
[[nodiscard]] std::span<const PixelFormat> pixel_formats();
/// Returns the null pointer when there is none.
[[nodiscard]] const PixelFormat* find_pixel_format(const char* name);

/// Rows of `from` begin `stride` bytes apart. The caller keeps the last one inside.
void copy_luma(const PixelFormat& format, std::span<const std::uint8_t> from, std::size_t stride, MutableGrayView to);

}  // namespace ilp
