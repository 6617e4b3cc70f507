// A map that is computed from formulas, tile by tile, as no file of the writers is.
#pragma once

#include <cmath>
#include <limits>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::test {

struct MadeUpMap {
  std::int32_t columns = 700, rows = 600, tile_side = 256;
  double x0 = -40, y0 = 25, cell = 0.125;
  std::int32_t hole_from = 100, hole_to = 140;       ///< columns and rows where nothing was seen
  std::int32_t spike_column = 500, spike_row = 420;  ///< a single cell 50 above the rest
  bool sigma_given = true;

  [[nodiscard]] bool seen(std::int32_t column, std::int32_t row) const {
    return !(column >= hole_from && column < hole_to && row >= hole_from && row < hole_to);
  }
  [[nodiscard]] double height(std::int32_t column, std::int32_t row) const {
    const double x = x0 + column * cell, y = y0 - row * cell;
    return 2 + 0.1 * x - 0.05 * y + (column == spike_column && row == spike_row ? 50 : 0);
  }
  [[nodiscard]] double sigma(std::int32_t column) const { return 0.01 + 1e-5 * column; }
  [[nodiscard]] std::uint8_t grey(std::int32_t column, std::int32_t row) const {
    return static_cast<std::uint8_t>((column + row) % 256);
  }
  [[nodiscard]] std::uint16_t count(std::int32_t column) const {
    return static_cast<std::uint16_t>(column < 10 ? 0 : 1 + column / 100);
  }

  [[nodiscard]] map::MapTile tile(std::int32_t tile_column, std::int32_t tile_row) const {
    constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
    map::MapTile out;
    out.column = tile_column * tile_side;
    out.row = tile_row * tile_side;
    const std::int32_t w = std::min(tile_side, columns - out.column), h = std::min(tile_side, rows - out.row);
    out.height = host::Raster<float>(w, h, nothing);
    out.sigma = host::Raster<float>(w, h, nothing);
    out.ortho = host::Raster<std::uint8_t>(w, h);
    out.count = host::Raster<std::uint16_t>(w, h);
    out.source = host::Raster<std::uint16_t>(w, h);
    for (std::int32_t y = 0; y < h; ++y) {
      for (std::int32_t x = 0; x < w; ++x) {
        const std::int32_t column = out.column + x, row = out.row + y;
        if (!seen(column, row)) continue;
        out.height.at(x, y) = static_cast<float>(height(column, row));
        if (sigma_given) out.sigma.at(x, y) = static_cast<float>(sigma(column));
        out.ortho.at(x, y) = grey(column, row);
        out.count.at(x, y) = count(column);
      }
    }
    return out;
  }

  /// The map must outlive it.
  [[nodiscard]] map::Mosaic mosaic() const {
    map::Mosaic out;
    out.geometry = {x0, y0, cell, columns, rows};
    out.tile_columns = (columns + tile_side - 1) / tile_side;
    out.tile_rows = (rows + tile_side - 1) / tile_side;
    out.tile_side = tile_side;
    out.tile = [this](std::int32_t column, std::int32_t row) { return std::optional(tile(column, row)); };
    return out;
  }
};

}  // namespace ilp::test
