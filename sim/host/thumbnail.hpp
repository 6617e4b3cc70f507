// Rasters made smaller for pages.
#pragma once

#include <algorithm>
#include <cstdint>

#include "sim/host/raster.hpp"

namespace ilp::host {

/// Every output pixel is mean(raster, x0, y0, factor) of a block; the blocks are the smallest with which the result is
/// less than twice as wide as `width`.
template <typename T, typename Mean>
[[nodiscard]] Raster<T> shrink(const Raster<T>& image, std::int32_t width, Mean mean) {
  const std::int32_t factor = std::max(1, image.width / width);
  Raster<T> small(std::max(1, image.width / factor), std::max(1, image.height / factor));
  for (std::int32_t y = 0; y < small.height; ++y) {
    for (std::int32_t x = 0; x < small.width; ++x) small.at(x, y) = mean(image, x * factor, y * factor, factor);
  }
  return small;
}

[[nodiscard]] std::uint8_t mean_grey(const Raster<std::uint8_t>& image, std::int32_t x0, std::int32_t y0,
                                     std::int32_t factor);
/// The mean of depths that are given as inverse depths; NaN where there is none.
[[nodiscard]] float mean_depth(const Raster<float>& inverse, std::int32_t x0, std::int32_t y0, std::int32_t factor);

}  // namespace ilp::host
