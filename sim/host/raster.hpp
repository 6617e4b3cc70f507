// An image or grid that owns its samples, and colours.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/base/image_view.hpp"

namespace ilp::host {

/// Samples are row-major without gaps; (0, 0) is the first. Indices are not checked.
template <typename T>
struct Raster {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<T> samples;

  Raster() = default;
  Raster(std::int32_t w, std::int32_t h, T value = T{})
      : width(w), height(h), samples(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}

  [[nodiscard]] bool empty() const { return samples.empty(); }
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool contains(std::int32_t x, std::int32_t y) const {
    return x >= 0 && y >= 0 && x < width && y < height;
  }
  [[nodiscard]] T& at(std::int32_t x, std::int32_t y) { return samples[index(x, y)]; }
  [[nodiscard]] const T& at(std::int32_t x, std::int32_t y) const { return samples[index(x, y)]; }
  [[nodiscard]] bool same_size(std::int32_t w, std::int32_t h) const { return width == w && height == h; }
  [[nodiscard]] ImageView<T> view() { return {samples.data(), width, height}; }
  [[nodiscard]] ImageView<const T> view() const { return {samples.data(), width, height}; }
};

/// Copies the part with the first sample (x, y), which must lie inside the raster.
template <typename T>
[[nodiscard]] Raster<T> part_of(const Raster<T>& raster, std::int32_t x, std::int32_t y, std::int32_t width,
                                std::int32_t height) {
  Raster<T> part(width, height);
  for (std::int32_t j = 0; j < height; ++j) {
    std::copy_n(&raster.samples[raster.index(x, y + j)], width, &part.samples[part.index(0, j)]);
  }
  return part;
}

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
};

}  // namespace ilp::host
