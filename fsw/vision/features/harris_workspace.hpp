// Scratch of detect_corners; a component owns one.
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

  // Rows at a distance of 4096 bytes would share eight places of the first cache: then corners take half as long again.
  static constexpr std::size_t apart = 16;
  using Row = std::array<std::int32_t, limits::max_image_side + apart>;
  std::array<std::int16_t, limits::max_image_side> gradient_x, gradient_y;
  Row product;                                              ///< of the gradients, one row
  std::array<Row, window> tensor_xx, tensor_xy, tensor_yy;  ///< smoothed along the row; the latest rows
  std::array<float, limits::max_image_pixels> response;
  std::array<CornerCandidate, max_candidates> found, sorted;
  std::array<std::uint32_t, max_buckets + 1> bucket_begin;
  std::array<std::uint32_t, max_buckets> bucket_taken;
  struct Progress {
    std::int32_t next_row;  ///< of the response
    float strongest;        ///< response so far
  };
  Progress progress;
};

}  // namespace ilp
