// Pixel formats of V4L2 that the flight can convert to grey images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// Layout of a row's values in memory. In mipi10 and mipi12 the last byte of a group holds the lower bits of its
/// values; those of the first value are least significant.
enum class Packing : std::uint8_t {
  bytes,   ///< one byte per value; the first value is at `offset`, the next ones `step` bytes apart
  words,   ///< 16 bits per value, low byte first; a value above 2^bits - 1 is clamped
  mipi10,  ///< four values in five bytes: a byte with the upper 8 bits of each, then a byte with the lower 2 bits
  mipi12,  ///< two values in three bytes: a byte with the upper 8 bits of each, then a byte with the lower 4 bits
  jpeg     ///< the picture is a JPEG file
};

struct PixelFormat {
  std::uint32_t fourcc;  ///< V4L2_PIX_FMT_...
  const char* name;      ///< the part of the constant's name after V4L2_PIX_FMT_
  Packing packing;
  std::uint8_t bits;    ///< bits of a value
  bool mosaic;          ///< a mosaic of red, green and blue pixels (Bayer) in any order
  std::uint8_t step;    ///< for Packing::bytes, bytes from one value to the next
  std::uint8_t offset;  ///< for Packing::bytes, bytes before the first value
};

/// Returns all formats, the preferred one first.
[[nodiscard]] std::span<const PixelFormat> pixel_formats();
/// Finds a format by its name or by its four-character code, such as SRGGB10P or pRAA. Returns the null pointer if
/// there is none.
[[nodiscard]] const PixelFormat* find_pixel_format(const char* name);

/// Bytes of a row of `width` pixels without padding; for a format in planes, of a row of luma; for JPEG 0.
[[nodiscard]] std::size_t row_bytes(const PixelFormat& format, std::int32_t width);
/// A number of bytes after which the bytes of a uniform row repeat.
[[nodiscard]] std::size_t period_bytes(const PixelFormat& format);

/// A four-character code as text, without blanks at its end.
struct FourccText {
  char text[5] = {};
};
[[nodiscard]] FourccText fourcc_text(std::uint32_t fourcc);

}  // namespace ilp
