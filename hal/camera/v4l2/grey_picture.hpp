// Converts pictures of a video device to grey images of 8 bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/camera/picture/reduction.hpp"
#include "hal/camera/v4l2/pixel_format.hpp"

namespace ilp {

/// A picture as the driver delivers it. A format in planes begins with the plane of luma.
struct RawPicture {
  PixelFormat format{};
  std::span<const std::uint8_t> bytes;
  std::int32_t width = 0, height = 0;  ///< px
  std::size_t stride = 0;              ///< bytes from the beginning of a row to that of the next; 0 for JPEG
};

/// Converts a picture row by row, so that its memory does not depend on the picture's height.
class GreyConverter {
 public:
  /// Fills `image`, which has the size of `reduction`. `reduction` is that of find_reduction() for the picture's size.
  ///
  /// The grey value of a pixel is its value divided by 2^(bits - 8) and rounded down. For formats with colour
  /// difference it is the byte of luma. The range of the camera's values is not changed.
  ///
  /// In a mosaic, the grey value is the mean of the 3 x 3 pixels around the pixel with the weights 1 2 1, 2 4 2, 1 2 1,
  /// divided by 2^(bits - 8) and rounded down. Every pixel thus gets a quarter of red, half of green and a quarter of
  /// blue in any order of the mosaic. At the border, missing rows and columns are mirrored at the outermost one.
  ///
  /// Returns `camera_layout` (first value: bytes present, second: bytes needed) if a row or the picture does not fit
  /// `bytes`, `image_too_large` if a side exceeds limits::max_sensor_side or is below 2, and the statuses of
  /// decode_grey_jpeg() for JPEG.
  Status convert(const RawPicture& picture, const Reduction& reduction, MutableGrayView image);

 private:
  using Values = std::array<std::uint16_t, static_cast<std::size_t>(limits::max_sensor_side)>;

  std::span<const std::uint8_t> grey_row(const RawPicture& picture, std::int32_t y);
  std::span<const std::uint8_t> mosaic_row(const RawPicture& picture, std::int32_t y);
  const Values& values(const RawPicture& picture, std::int32_t y);

  RowReducer reducer_;
  std::array<Values, 3> values_{};           ///< unpacked values of three rows
  std::array<std::int32_t, 3> values_of_{};  ///< index of the row in each of `values_`; -1: none
  std::array<std::uint32_t, static_cast<std::size_t>(limits::max_sensor_side) + 2> columns_{};
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_sensor_side)> row_{};
};

}  // namespace ilp
