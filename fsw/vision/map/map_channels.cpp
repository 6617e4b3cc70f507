#include "fsw/vision/map/map_channels.hpp"

namespace ilp {
namespace {

constexpr double deviation = 256;
constexpr double largest = 8 * deviation - 1;
constexpr float longest = 127;

/// Down a column: smoothed, and its derivative. False where a value is unknown.
bool column_sums(const MapRows& rows, std::int32_t column, std::int32_t& smooth, std::int32_t& slope) {
  std::int32_t v[5];
  for (int k = 0; k < 5; ++k) v[k] = rows.row[k][column];
  smooth = v[0] + 4 * v[1] + 6 * v[2] + 4 * v[3] + v[4];
  slope = v[4] + 2 * v[3] - 2 * v[1] - v[0];
  return *std::min_element(v, v + 5) != unknown_value;
}

}  // namespace

void gradient_row(const MapRows& rows, std::int32_t* along_x, std::int32_t* along_y) {
  std::fill_n(along_x, rows.width, 0);
  std::fill_n(along_y, rows.width, 0);
  std::int32_t smooth[5] = {}, slope[5] = {};
  std::int32_t known = 0;  // columns in a row, up to this one
  for (std::int32_t column = 0; column < rows.width; ++column) {
    for (int k = 0; k < 4; ++k) {
      smooth[k] = smooth[k + 1];
      slope[k] = slope[k + 1];
    }
    known = column_sums(rows, column, smooth[4], slope[4]) ? known + 1 : 0;
    if (known < 5) continue;
    along_x[column - 2] = smooth[4] + 2 * smooth[3] - 2 * smooth[1] - smooth[0];
    along_y[column - 2] = slope[0] + 4 * slope[1] + 6 * slope[2] + 4 * slope[3] + slope[4];
  }
}

void direction_row(const std::int32_t* along_x, const std::int32_t* along_y, std::int32_t width, float soft,
                   std::int8_t* direction) {
  for (std::ptrdiff_t k = 0; k < width; ++k) {
    const auto x = static_cast<float>(along_x[k]), y = static_cast<float>(along_y[k]);
    const float scale = longest / (std::sqrt(x * x + y * y) + soft + 1.0F);
    direction[2 * k] = static_cast<std::int8_t>(x * scale);
    direction[2 * k + 1] = static_cast<std::int8_t>(y * scale);
  }
}

void GradientSizes::add_row(const std::int32_t* along_x, const std::int32_t* along_y, std::int32_t width) {
  for (std::int32_t k = 0; k < width; ++k) {
    if (along_x[k] == 0 && along_y[k] == 0) continue;
    const double x = along_x[k], y = along_y[k];
    sum += std::sqrt(x * x + y * y);
    ++count;
  }
}

ValueScale normalise_values(std::int16_t* values, std::size_t count) {
  std::int64_t sum = 0, squares = 0, known = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (values[k] == unknown_value) continue;
    sum += values[k];
    squares += std::int64_t{values[k]} * values[k];
    ++known;
  }
  if (known == 0) return {};
  const double mean = static_cast<double>(sum) / static_cast<double>(known);
  const double variance = static_cast<double>(squares) / static_cast<double>(known) - mean * mean;
  const double scale = variance > 0 ? deviation / std::sqrt(variance) : 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (values[k] == unknown_value) continue;
    values[k] = static_cast<std::int16_t>(std::clamp(scale * (values[k] - mean), -largest, largest));
  }
  return {mean, scale};
}

}  // namespace ilp
