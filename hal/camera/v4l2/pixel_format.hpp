// Pixel formats of V4L2 that the flight understands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// How the values of a row lie in memory.
enum class Packing : std::uint8_t {
  bytes,   ///< a value is a byte; the values of neighbouring pixels are `step` bytes apart, the first one at `offset`
  words,   ///< 16 bits, the low byte first; a value beyond its bits counts as the largest one
  mipi10,  ///< four values in five bytes: their upper 8 bits, then the lower two of each, the first one lowest
  mipi12,  ///< two values in three bytes: their upper 8 bits, then the lower four of each, the first one lowest
  jpeg     ///< the picture is a JPEG file
};

struct PixelFormat {
  std::uint32_t fourcc;  ///< V4L2_PIX_FMT_...
  const char* name;      ///< as after V4L2_PIX_FMT_
  Packing packing;
  std::uint8_t bits;  ///< of a value
  bool mosaic;        ///< of red, green and blue pixels (Bayer), in any order
  std::uint8_t step;
  std::uint8_t offset;
};

/// In the order of preference.
[[nodiscard]] std::span<const PixelFormat> pixel_formats();
/// Finds a format by its name or by its four-character code, such as SRGGB10P or pRAA. Returns the null pointer when
/// there is none.
[[nodiscard]] const PixelFormat* find_pixel_format(const char* name);

/// Bytes of a row of `width` pixels without padding; of a format in planes, of its plane of luma. 0 for JPEG.
[[nodiscard]] std::size_t row_bytes(const PixelFormat& format, std::int32_t width);
/// Bytes after which a uniform row repeats itself, at most.
[[nodiscard]] std::size_t period_bytes(const PixelFormat& format);

/// A four-character code as text, without blanks at its end.
struct FourccText {
  char text[5] = {};
};
[[nodiscard]] FourccText fourcc_text(std::uint32_t fourcc);

}  // namespace ilp
