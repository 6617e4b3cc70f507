// Makes pictures from rasters: reduced in size, coloured, and encoded as PNG for files and for embedding in pages.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/host/raster.hpp"

namespace ilp::host {

// Encodes bytes as text, for pages that contain their data.

/// Base64 of RFC 4648, with padding.
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

/// Base64 of the array's memory, which is little-endian (checked at compile time).
template <typename T>
[[nodiscard]] std::string base64_of(std::span<const T> values) {
  return base64({reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()});
}

struct Rgba {
  std::uint8_t r = 0, g = 0, b = 0, a = 0;
};

[[nodiscard]] std::vector<std::uint8_t> png_bytes(const Raster<std::uint8_t>& grey);
[[nodiscard]] std::vector<std::uint8_t> png_bytes(const Raster<Rgba>& picture);
/// A PNG in which grey 0 is transparent.
[[nodiscard]] std::vector<std::uint8_t> png_bytes_where_seen(const Raster<std::uint8_t>& grey);

/// `data:image/png;base64,...`
[[nodiscard]] std::string data_uri(const std::vector<std::uint8_t>& png);

// Shows numbers as colours. Both colour maps are readable without colour vision.

/// The colour of `t`, which is clamped to [0, 1].
using ColourMap = Rgb (*)(double t);
/// Perceptually uniform, dark to light.
[[nodiscard]] Rgb viridis(double t);
/// For differences: blue below 0.5, white at 0.5, red above (ColorBrewer RdBu, reversed).
[[nodiscard]] Rgb diverging(double t);

struct ValueRange {
  double low = 0, high = 1;
};
/// The 2nd and 98th percentile of the finite values, so that outliers do not use up the colours. If both are equal, 0.5
/// around them; [0, 1] without finite values.
[[nodiscard]] ValueRange display_range(const Raster<float>& values);
/// Values that are not finite become transparent.
[[nodiscard]] Raster<Rgba> colour_mapped(const Raster<float>& values, const ValueRange& range,
                                         ColourMap colours = viridis);

// Reduces rasters for pages.

/// Reduces a raster by an integer factor: each output pixel is mean(image, x0, y0, factor) of a block of factor x
/// factor pixels. The factor is image.width / width, rounded down, but at least 1, so that the result is less than
/// twice as wide as `width`.
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
/// Harmonic mean of the depths of a block, from their inverses; NaN if no inverse depth is positive.
[[nodiscard]] float mean_depth(const Raster<float>& inverse, std::int32_t x0, std::int32_t y0, std::int32_t factor);

}  // namespace ilp::host
