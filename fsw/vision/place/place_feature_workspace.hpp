// Scratch of find_place_features; a component owns one.
#pragma once

#include <array>

#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/place/place_features.hpp"

namespace ilp {

struct PlaceFeatureWorkspace {
  // Level 0 has 9/16 of the image's pixels, and half a pixel more along each side by rounding.
  static constexpr std::size_t max_level_pixels =
      limits::max_image_pixels * 9 / 16 + limits::max_image_width + limits::max_image_height;

  std::array<std::uint8_t, max_level_pixels> level, next_level;
  std::array<std::uint16_t, max_level_pixels> smooth;  ///< sums over a box around each pixel
  std::array<std::uint16_t, limits::max_image_side> columns;
  Corners corners;
  struct Progress {
    int at_level;        ///< level in which features are searched for
    bool level_begun;    ///< the level is reduced, and the search for its corners has begun
    bool corners_found;  ///< the search for its corners is complete
  };
  Progress progress;
};

}  // namespace ilp
