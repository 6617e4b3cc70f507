// Scratch memory of detect_corners. The caller keeps one, in static memory because of its size.
#pragma once

#include <array>

#include "fsw/vision/features/harris.hpp"

namespace ilp {

struct CornerCandidate {
  float response;
  std::int16_t x, y;
  std::uint16_t bucket;
};

struct HarrisWorkspace {
  static constexpr std::size_t window = 5;
  static constexpr std::size_t max_buckets = 1024;
  // Local maxima are at least three pixels apart in x or y.
  static constexpr std::size_t max_candidates =
      limits::max_image_pixels / 9 + limits::max_image_width + limits::max_image_height;

  // Padding of a row, elements. Rows 4096 bytes apart would share one set of eight lines in the first-level cache, and
  // detection would take half as long again.
  static constexpr std::size_t apart = 16;
  using Row = std::array<std::int32_t, limits::max_image_side + apart>;
  std::array<std::int16_t, limits::max_image_side> gradient_x, gradient_y;
  Row product;  ///< product of two gradients, one row
  /// Structure tensor, smoothed along the row; the latest five rows.
  std::array<Row, window> tensor_xx, tensor_xy, tensor_yy;
  std::array<float, limits::max_image_pixels> response;
  std::array<CornerCandidate, max_candidates> found, sorted;
  std::array<std::uint32_t, max_buckets + 1> bucket_begin;
  std::array<std::uint32_t, max_buckets> bucket_taken;
  struct Progress {
    std::int32_t next_row;  ///< next row whose response is computed
    float strongest;        ///< strongest response so far
  };
  Progress progress;
};

}  // namespace ilp
