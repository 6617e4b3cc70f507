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
  static constexpr std::size_t max_buckets = 1024;
  // Local maxima are at least three pixels apart in x or y.
  static constexpr std::size_t max_candidates =
      limits::max_image_pixels / 9 + limits::max_image_width + limits::max_image_height;

  using Row = std::array<std::int32_t, limits::max_image_side>;
  /// One element of the structure tensor, row after row.
  struct Tensor {
    std::array<Row, 5> rows;   ///< the latest, smoothed along the row
    std::array<Row, 3> boxes;  ///< the latest sums of five of them
    Row box, smooth;           ///< running sums: of `rows`; of `boxes`, which is smoothed both ways
  };
  std::array<std::int16_t, limits::max_image_side> gradient_x, gradient_y;
  Row product, box_of_five;
  Tensor xx, xy, yy;
  std::array<float, limits::max_image_pixels> response;
  std::array<CornerCandidate, max_candidates> found, sorted;
  std::array<std::uint32_t, max_buckets + 1> bucket_begin;
  std::array<std::uint32_t, max_buckets> bucket_taken;
};

}  // namespace ilp
