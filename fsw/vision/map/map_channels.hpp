// Turns raw values of a window or a sheet into what patches are compared by (MapChannels).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Rows about one of them, of a plane of raw values.
struct MapRows {
  const std::int16_t* row[5];
  std::int32_t width;
};
/// The gradient along x and y at the columns of a row, by Sobel's operator on values that are smoothed by a binomial of
/// 3 x 3: 5 x 5 in all. Both are 0 where one of the 5 x 5 is unknown.
void gradient_row(const MapRows& rows, std::int32_t* along_x, std::int32_t* along_y);
/// Directions of length 127 m / (m + soft) for gradients of size m, interleaved.
void direction_row(const std::int32_t* along_x, const std::int32_t* along_y, std::int32_t width, float soft,
                   std::int8_t* direction);
/// Mean of the sizes of gradients that are not 0.
struct GradientSizes {
  double sum = 0;
  std::int64_t count = 0;

  void add_row(const std::int32_t* along_x, const std::int32_t* along_y, std::int32_t width);
  [[nodiscard]] float mean() const { return count > 0 ? static_cast<float>(sum / static_cast<double>(count)) : 0; }
};
/// How values were made from raw ones: value = scale (raw - mean).
struct ValueScale {
  double mean = 0, scale = 0;
};
/// Raw values to values: about their mean, with the standard deviation 256. Unknown ones stay unknown.
ValueScale normalise_values(std::int16_t* values, std::size_t count);

template <std::int32_t side>
[[nodiscard]] MapRows rows_about(const MapChannels<side>& channels, std::int32_t row) {
  MapRows rows{};
  for (std::int32_t k = 0; k < 5; ++k) rows.row[k] = channels.value.data() + channels.at(0, row - 2 + k);
  rows.width = channels.width;
  return rows;
}

/// Mean size of the gradients in every fourth row.
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

/// Directions of the rows [first, last); those of the two rows at each border are 0.
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
