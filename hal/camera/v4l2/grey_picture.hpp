// Pictures of a video device become grey images of 8 bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/camera/picture/reduction.hpp"
#include "hal/camera/v4l2/pixel_format.hpp"

namespace ilp {

/// Rows of `bytes` begin `stride` bytes apart; of a format in planes, the plane of luma comes first.
struct RawPicture {
  PixelFormat format{};
  std::span<const std::uint8_t> bytes;
  std::int32_t width = 0, height = 0;
  std::size_t stride = 0;
};

/// Converts one row after the other, so that its memory does not grow with the picture's height.
class GreyConverter {
 public:
  /// Fills `image`, which gets the size of `reduction`, made by find_reduction() for the picture's size.
  ///
  /// The grey value of a pixel is, rounded down to 8 bits,
  /// - its value divided by 2^(bits - 8), or its byte of luma, in whatever range the camera uses;
  /// - in a mosaic, the mean of the four cells of 2 x 2 pixels that contain it, (R + 2 G + B) / 4 of each. These are
  /// the
  ///   3 x 3 pixels around it with the weights 1 2 1, 2 4 2, 1 2 1: a quarter of red, half of green and a quarter of
  ///   blue at every pixel, whatever the mosaic begins with. Beyond the border, pixels are mirrored at the border's.
  ///
  /// `camera_layout` (bytes that there are, bytes that are needed) for a row or a picture that does not fit `bytes`,
  /// and a JPEG file's Status (decode_grey_jpeg).
  Status convert(const RawPicture& picture, const Reduction& reduction, MutableGrayView image);

 private:
  using Values = std::array<std::uint16_t, static_cast<std::size_t>(limits::max_sensor_side)>;

  std::span<const std::uint8_t> grey_row(const RawPicture& picture, std::int32_t y);
  std::span<const std::uint8_t> mosaic_row(const RawPicture& picture, std::int32_t y);
  const Values& values(const RawPicture& picture, std::int32_t y);

  RowReducer reducer_;
  std::array<Values, 3> values_{};
  std::array<std::int32_t, 3> values_of_{};  ///< rows in `values_`; -1 for none
  std::array<std::uint32_t, static_cast<std::size_t>(limits::max_sensor_side) + 2> columns_{};
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_sensor_side)> row_{};
};

}  // namespace ilp
