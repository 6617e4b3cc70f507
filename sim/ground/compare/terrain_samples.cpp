#include "sim/ground/compare/terrain_samples.hpp"

#include <algorithm>
#include <cmath>

namespace ilp::compare {
namespace {

constexpr std::int32_t fields = 8;

std::uint8_t field_of(const HeightModel& map, std::int32_t column, std::int32_t row) {
  const std::int32_t i = fields * column / map.reduced_columns(), j = fields * row / map.reduced_rows();
  return static_cast<std::uint8_t>((i + j) % 2);
}

void add_block(HeightModel& map, const ModelFrames& frames, std::int32_t x0, std::int32_t y0, std::int32_t stride,
               TerrainSamples& samples) {
  const std::size_t first = samples.cells.size();
  const auto scale = static_cast<std::uint32_t>(samples.scales.size());
  std::vector<double> x, y;
  const std::int32_t x1 = std::min(x0 + block_side, map.reduced_columns());
  const std::int32_t y1 = std::min(y0 + block_side, map.reduced_rows());
  for (std::int32_t row = (y0 + stride - 1) / stride * stride; row < y1; row += stride) {
    for (std::int32_t column = (x0 + stride - 1) / stride * stride; column < x1; column += stride) {
      const float height = map.cell(column, row);
      if (!std::isfinite(height)) continue;
      TerrainSample sample;
      sample.place = frames.common_from_map() * map_point(map, column, row, double{height});
      sample.scale = scale;
      sample.half = field_of(map, column, row);
      samples.cells.push_back(sample);
      x.push_back(sample.place.x());
      y.push_back(sample.place.y());
    }
  }
  if (x.empty()) return;
  samples.scales.push_back(pixel_scale(frames, x[x.size() / 2], y[y.size() / 2], samples.cell));
  frames.to_pixels(x, y);
  for (std::size_t i = 0; i < x.size(); ++i) {
    samples.cells[first + i].column = x[i];
    samples.cells[first + i].row = y[i];
  }
}

}  // namespace

double PixelScale::pixel() const {
  return 1 / std::sqrt(std::fabs(column_x * row_y - column_y * row_x));
}

PixelScale pixel_scale(const ModelFrames& frames, double x, double y, double step) {
  std::vector<double> columns{x - step, x + step, x, x}, rows{y, y, y - step, y + step};
  frames.to_pixels(columns, rows);
  return {(columns[1] - columns[0]) / (2 * step), (columns[3] - columns[2]) / (2 * step),
          (rows[1] - rows[0]) / (2 * step), (rows[3] - rows[2]) / (2 * step)};
}

Vec3 map_point(const HeightModel& map, std::int32_t column, std::int32_t row, double height) {
  const GeoTransform& t = map.transform();
  const double i = (column + 0.5) * map.factor(), j = (row + 0.5) * map.factor();
  return {t[0] + i * t[1] + j * t[2], t[3] + i * t[4] + j * t[5], height};
}

double side_of_pixel(const HeightModel& map) {
  const GeoTransform& t = map.transform();
  return std::sqrt(std::fabs(t[1] * t[5] - t[2] * t[4]));
}

TerrainSamples take_samples(HeightModel& map, const ModelFrames& frames, std::size_t most) {
  TerrainSamples samples;
  samples.cell = side_of_pixel(map) * map.factor() * frames.common_from_map().scale;
  const double cells = double(map.reduced_columns()) * map.reduced_rows();
  const auto stride = std::max(1, static_cast<std::int32_t>(std::ceil(std::sqrt(cells / static_cast<double>(most)))));
  for (std::int32_t y = 0; y < map.reduced_rows(); y += block_side) {
    for (std::int32_t x = 0; x < map.reduced_columns(); x += block_side) add_block(map, frames, x, y, stride, samples);
  }
  return samples;
}

}  // namespace ilp::compare
