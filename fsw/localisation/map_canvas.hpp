// A window of the map, resampled tile by tile to a working pixel that is not smaller than the map's.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/maps/map_tile.hpp"
#include "fsw/vision/map/map_plan.hpp"

namespace ilp {

inline constexpr std::size_t max_canvas_cells = std::size_t{max_map_window_side} * max_map_window_side;
/// Largest side of a cell in pixels of the map: with more, the sums would overflow.
inline constexpr double most_canvas_ratio = 30;

struct MapCanvas {
  std::array<std::uint8_t, max_canvas_cells> image;
  std::array<float, max_canvas_cells> height_m;
  std::array<std::uint8_t, max_canvas_cells> known;
  std::array<std::uint32_t, max_canvas_cells> sum, weight;
};

/// A range of a layer's tiles; the last row and column are included.
struct MapTileRange {
  std::int32_t first_row = 0, last_row = -1, first_column = 0, last_column = -1;

  [[nodiscard]] std::int64_t count() const {
    return last_row < first_row || last_column < first_column
               ? 0
               : (std::int64_t{last_row} - first_row + 1) * (std::int64_t{last_column} - first_column + 1);
  }
};
/// The range of the layer's tiles that the window touches.
[[nodiscard]] MapTileRange tiles_under(const MapPlan& plan, const MapLayer& layer);

/// Makes all cells unknown.
void begin_canvas(const MapPlan& plan, MapCanvas& canvas);
/// Adds a tile of the layer: the grey value of a cell is the mean of the map's pixels in its area, and its height is
/// that of its centre, interpolated bilinearly between posts. Returns `invalid_argument` (map_window) if the window's
/// pixel is smaller than the layer's, or larger by more than a factor of most_canvas_ratio.
Status paint_tile(const MapTile& tile, const MapLayer& layer, const MapPlan& plan, MapCanvas& canvas);
/// Completes the window after the last tile. Cells of which less than half is known become unknown.
void finish_canvas(const MapPlan& plan, const MapLayer& layer, MapCanvas& canvas);

/// The canvas in the form that registration needs.
[[nodiscard]] MapWindow window_of(const MapPlan& plan, const MapDirectory& directory, const MapCanvas& canvas);

/// Height of the ground at a point of the map inside the tile, interpolated between posts, or the mean of all known
/// posts if those around the point are unknown. Returns false for a point outside the tile, or a tile without heights.
[[nodiscard]] bool tile_height(const MapTile& tile, const MapLayer& layer, double x_m, double y_m, double& height_m);

}  // namespace ilp
