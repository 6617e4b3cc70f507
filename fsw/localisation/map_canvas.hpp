// A window of the map at any pixel that is not finer than the map's, painted tile by tile.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/maps/map_tile.hpp"
#include "fsw/vision/map/map_plan.hpp"

namespace ilp {

inline constexpr std::size_t max_canvas_cells = std::size_t{max_map_window_side} * max_map_window_side;
/// Pixels of the map along a side of a cell, at most: sums of more would not fit.
inline constexpr double most_canvas_ratio = 30;

struct MapCanvas {
  std::array<std::uint8_t, max_canvas_cells> image;
  std::array<float, max_canvas_cells> height_m;
  std::array<std::uint8_t, max_canvas_cells> known;
  std::array<std::uint32_t, max_canvas_cells> sum, weight;
};

/// Range of a layer's tiles, last ones included.
struct MapTileRange {
  std::int32_t first_row = 0, last_row = -1, first_column = 0, last_column = -1;

  [[nodiscard]] std::int64_t count() const {
    return last_row < first_row || last_column < first_column
               ? 0
               : (std::int64_t{last_row} - first_row + 1) * (std::int64_t{last_column} - first_column + 1);
  }
};
/// The tiles of the layer, of those it has, that the window touches.
[[nodiscard]] MapTileRange tiles_under(const MapPlan& plan, const MapLayer& layer);

/// Nothing is known of the window.
void begin_canvas(const MapPlan& plan, MapCanvas& canvas);
/// Adds a tile of the layer: each cell becomes the mean of the map's pixels over its area, and has the height of its
/// centre, bilinear between posts. `invalid_argument` (map_window) for a window with a finer pixel, or one coarser than
/// most_canvas_ratio.
Status paint_tile(const MapTile& tile, const MapLayer& layer, const MapPlan& plan, MapCanvas& canvas);
/// A cell of which less than half is known is unknown.
void finish_canvas(const MapPlan& plan, const MapLayer& layer, MapCanvas& canvas);

/// The canvas as registration takes it.
[[nodiscard]] MapWindow window_of(const MapPlan& plan, const MapDirectory& directory, const MapCanvas& canvas);

/// Height of a tile's ground at a place of the map; the mean of its known posts where the ones about the place are not
/// known. False for a place outside the tile, or a tile without heights.
[[nodiscard]] bool tile_height(const MapTile& tile, const MapLayer& layer, double x_m, double y_m, double& height_m);

}  // namespace ilp
