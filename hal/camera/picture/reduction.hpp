// A source's pictures may be larger than the flight's images: they are cut around their middle and binned.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Pixel (x, y) of the image is the mean of the `factor` x `factor` pixels of the picture from
/// (left + factor * x, top + factor * y) on, rounded to the nearest number.
struct Reduction {
  std::int32_t factor = 1;
  std::int32_t left = 0, top = 0;      ///< picture px
  std::int32_t width = 0, height = 0;  ///< of the image, px

  [[nodiscard]] bool changes_nothing() const { return factor == 1 && left == 0 && top == 0; }
};

/// The one rule for all sources: `factor` is the smallest number with which at least nine tenths of the picture's width
/// and of its height fit limits::max_image_width and limits::max_image_height. What does not fit is cut off on both
/// sides alike. A picture that fits stays as it is. `image_too_large` (the picture's sides) beyond
/// limits::max_sensor_side, and for a picture whose image would have a side without a pixel.
Status find_reduction(std::int32_t width, std::int32_t height, Reduction& reduction);

/// The camera of the image, where `camera` is that of the picture. Pixel centres lie at integers in both.
[[nodiscard]] CameraModel reduced_camera(const CameraModel& camera, const Reduction& reduction);

/// Makes an image from the rows of a picture, one at a time, so that no whole picture is ever in memory.
class RowReducer {
 public:
  /// `image` has the size of `reduction`, which find_reduction() made.
  void begin(const Reduction& reduction, MutableGrayView image);
  /// The picture's next row, as many pixels as the picture is wide. Rows after the last one are left out.
  void add(std::span<const std::uint8_t> row);
  /// Row of the picture that add() takes next.
  [[nodiscard]] std::int32_t next_row() const { return row_; }
  /// Whether that row is a part of the image.
  [[nodiscard]] bool wants_row() const;

 private:
  Reduction reduction_;
  MutableGrayView image_;
  std::int32_t row_ = 0;
  std::array<std::uint32_t, static_cast<std::size_t>(limits::max_image_width)> sums_{};
};

}  // namespace ilp
