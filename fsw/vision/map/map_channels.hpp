// Converts raw values of a window or a sheet to the channels by which patches are compared (MapChannels).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Five consecutive rows of raw values, around the middle one.
struct MapRows {
  const std::int16_t* row[5];
  std::int32_t width;
};
/// Writes the gradient along x and y for each column of the middle row: Sobel's operator after binomial smoothing over
/// 3 x 3, in total 5 x 5 values. Both are 0 if one of the 5 x 5 values is unknown.
void gradient_row(const MapRows& rows, std::int32_t* along_x, std::int32_t* along_y);
/// Writes the directions of gradients, x and y interleaved. A gradient of magnitude m gives the length 127 m / (m +
/// soft).
void direction_row(const std::int32_t* along_x, const std::int32_t* along_y, std::int32_t width, float soft,
                   std::int8_t* direction);
/// Mean magnitude of the gradients that are not 0.
struct GradientSizes {
  double sum = 0;
  std::int64_t count = 0;

  void add_row(const std::int32_t* along_x, const std::int32_t* along_y, std::int32_t width);
  [[nodiscard]] float mean() const { return count > 0 ? static_cast<float>(sum / static_cast<double>(count)) : 0; }
};
/// Conversion of raw values: value = scale (raw - mean).
struct ValueScale {
  double mean = 0, scale = 0;
};
/// Normalises raw values in place to the mean 0 and the standard deviation 256. Unknown values stay unknown.
ValueScale normalise_values(std::int16_t* values, std::size_t count);

template <std::int32_t side>
[[nodiscard]] MapRows rows_about(const MapChannels<side>& channels, std::int32_t row) {
  MapRows rows{};
  for (std::int32_t k = 0; k < 5; ++k) rows.row[k] = channels.value.data() + channels.at(0, row - 2 + k);
  rows.width = channels.width;
  return rows;
}

/// Mean magnitude of the gradients in every fourth row.
template <std::int32_t side>
[[nodiscard]] float mean_gradient(const MapChannels<side>& channels) {
  std::array<std::int32_t, static_cast<std::size_t>(side)> along_x, along_y;
  GradientSizes sizes;
  for (std::int32_t row = 2; row + 2 < channels.height; row += 4) {
    gradient_row(rows_about(channels, row), along_x.data(), along_y.data());
    sizes.add_row(along_x.data(), along_y.data(), channels.width);
  }
  return sizes.mean();
}

/// Fills the directions of the rows [first, last). In the two rows at each border they are 0.
template <std::int32_t side>
void fill_directions(MapChannels<side>& channels, float soft, std::int32_t first, std::int32_t last) {
  std::array<std::int32_t, static_cast<std::size_t>(side)> along_x, along_y;
  for (std::int32_t row = first; row < last; ++row) {
    std::int8_t* const direction = channels.direction.data() + 2 * channels.at(0, row);
    if (row < 2 || row + 2 >= channels.height) {
      std::fill_n(direction, 2 * channels.width, std::int8_t{0});
      continue;
    }
    gradient_row(rows_about(channels, row), along_x.data(), along_y.data());
    direction_row(along_x.data(), along_y.data(), channels.width, soft, direction);
  }
}

}  // namespace ilp
