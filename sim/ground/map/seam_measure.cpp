#include "sim/ground/map/seam_measure.hpp"

#include <cmath>

namespace ilp::map {
namespace {

constexpr std::int32_t reach = 2;

class Sums {
 public:
  void add(bool border, double second_difference) {
    Part& part = border ? border_ : other_;
    ++part.samples;
    part.squares += second_difference * second_difference;
  }
  [[nodiscard]] Roughness roughness() const {
    return {border_.samples, other_.samples, border_.root_mean_square(), other_.root_mean_square()};
  }

 private:
  struct Part {
    std::uint64_t samples = 0;
    double squares = 0;
    [[nodiscard]] double root_mean_square() const {
      return samples == 0 ? 0 : std::sqrt(squares / static_cast<double>(samples));
    }
  };
  Part border_, other_;
};

/// Cells i - reach * step to i + reach * step.
void add_sample(const MapTile& tile, std::size_t i, std::size_t step, double cell, Sums& height, Sums& grey) {
  bool border = false;
  for (std::size_t at = i - reach * step; at <= i + reach * step; at += step) {
    if (tile.source.samples[at] == 0) return;
    border = border || tile.source.samples[at] != tile.source.samples[i];
  }
  const auto second_difference = [&](const auto& raster) {
    return static_cast<double>(raster.samples[i - step]) - 2.0 * raster.samples[i] + raster.samples[i + step];
  };
  height.add(border, second_difference(tile.height) / cell);
  grey.add(border, second_difference(tile.ortho));
}

}  // namespace

SeamMeasure measure_seams(const Mosaic& mosaic) {
  Sums height, grey;
  for (std::int32_t row = 0; row < mosaic.tile_rows; ++row) {
    for (std::int32_t column = 0; column < mosaic.tile_columns; ++column) {
      const auto tile = mosaic.tile(column, row);
      if (!tile) continue;
      const auto width = static_cast<std::size_t>(tile->height.width);
      for (std::int32_t y = 0; y < tile->height.height; ++y) {
        for (std::int32_t x = 0; x < tile->height.width; ++x) {
          const std::size_t i = tile->height.index(x, y);
          const auto inside = [](std::int32_t at, std::int32_t size) { return at >= reach && at < size - reach; };
          if (inside(x, tile->height.width)) add_sample(*tile, i, 1, mosaic.geometry.cell, height, grey);
          if (inside(y, tile->height.height)) add_sample(*tile, i, width, mosaic.geometry.cell, height, grey);
        }
      }
    }
  }
  return {height.roughness(), grey.roughness()};
}

}  // namespace ilp::map
