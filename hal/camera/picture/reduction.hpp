// Reduces pictures of a source that are larger than the flight's images: they are cropped around their centre and
// binned.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Pixel (x, y) of the image is the mean of `factor` x `factor` pixels of the picture, rounded to the nearest integer.
/// The first of these pixels is (left + factor * x, top + factor * y).
struct Reduction {
  std::int32_t factor = 1;
  std::int32_t left = 0, top = 0;      ///< columns and rows cropped before the image, px of the picture
  std::int32_t width = 0, height = 0;  ///< size of the image, px

  [[nodiscard]] bool changes_nothing() const { return factor == 1 && left == 0 && top == 0; }
};

/// Finds the reduction for pictures of this size; all sources use it. `factor` is the smallest number with which at
/// least nine tenths of the picture's width and of its height fit limits::max_image_width and limits::max_image_height.
/// The rest is cropped equally on both sides. A picture that fits is not changed. Returns `image_too_large` (first
/// value: width, second: height) if a side exceeds limits::max_sensor_side or the image would have no pixel.
Status find_reduction(std::int32_t width, std::int32_t height, Reduction& reduction);

/// Returns the camera model of the image, where `camera` is the model of the picture. Pixel centres have integer
/// coordinates in both.
[[nodiscard]] CameraModel reduced_camera(const CameraModel& camera, const Reduction& reduction);

/// Makes an image from the rows of a picture, one row at a time, so that the complete picture is never in memory.
class RowReducer {
 public:
  /// Begins a picture. `reduction` is one of find_reduction(), and `image` has its size.
  void begin(const Reduction& reduction, MutableGrayView image);
  /// Adds the next row of the picture with all of its pixels. A row outside the image is ignored and may be empty.
  void add(std::span<const std::uint8_t> row);
  /// Index of the picture's row that add() takes next, from 0.
  [[nodiscard]] std::int32_t next_row() const { return row_; }
  /// Whether the next row contributes to the image.
  [[nodiscard]] bool wants_row() const;

 private:
  Reduction reduction_;
  MutableGrayView image_;
  std::int32_t row_ = 0;
  /// For each column of the image, sum of the pixels that were added to its current row.
  std::array<std::uint32_t, static_cast<std::size_t>(limits::max_image_width)> sums_{};
};

}  // namespace ilp
