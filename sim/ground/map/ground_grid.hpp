// A map that is held in memory: a regular grid in the strip's world with heights and an orthoimage (decisions.md, 8).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/map/height_error.hpp"
#include "sim/host/raster.hpp"

namespace ilp::map {

/// Ground that images show and no depth was measured of, laid on interpolated heights (laid_surface in merge.hpp): for
/// pictures only. Empty, or of the map's size.
struct LaidGround {
  host::Raster<float> height;          ///< world z; NaN where there is none, as where a height was measured
  host::Raster<std::uint8_t> grey;     ///< from 1; 0 where there is none
  host::Raster<std::uint16_t> source;  ///< as that of the map, while a tile is painted; else empty
};

/// Column i, row j stands at world (x0 + i * cell, y0 - j * cell): north (+y) is up, cell (0,0) is the top-left centre.
struct GroundGrid {
  double x0 = 0, y0 = 0, cell = 0;     ///< strip units
  host::Raster<float> height;          ///< world z; NaN where nothing was seen
  host::Raster<float> sigma;           ///< one sigma of the height, from matching; NaN where it is unknown
  host::Raster<float> whole_sigma;     ///< the same with all parts (height_error.hpp); empty: not computed
  host::Raster<std::uint8_t> ortho;    ///< grey value seen from above
  host::Raster<std::uint16_t> count;   ///< keyframes whose surface covers the cell
  host::Raster<std::uint16_t> source;  ///< 1 + place in the strip's keyframes of the one that is shown; 0: none
  LaidGround laid;

  /// Whole where it was computed, else of matching.
  [[nodiscard]] const host::Raster<float>& estimated_sigma() const { return whole_sigma.empty() ? sigma : whole_sigma; }

  GroundGrid() = default;
  /// A grid without any data.
  GroundGrid(double x, double y, double side, std::int32_t columns, std::int32_t rows);

  [[nodiscard]] double column_of(double x) const { return (x - x0) / cell; }
  [[nodiscard]] double row_of(double y) const { return (y0 - y) / cell; }
};

/// Of each cell; NaN where the error of matching is unknown.
[[nodiscard]] host::Raster<float> whole_sigma_of(const GroundGrid& grid, const HeightErrors& errors);

/// Medians over the cells with an estimated error; all 0 without any.
[[nodiscard]] HeightErrorParts usual_parts(const GroundGrid& grid, const HeightErrors& errors);

/// z = a x + b y + c.
struct Plane {
  double a = 0, b = 0, c = 0;
  [[nodiscard]] double at(double x, double y) const { return a * x + b * y + c; }
};
/// Least squares over all heights. The world of a strip knows no gravity: its mean slope depends on the attitude of the
/// first camera, so pictures show relief above the mean plane.
[[nodiscard]] Plane mean_plane(const GroundGrid& grid);

// The elevation map of a strip in tiles. A map may have any size: only one tile at a time is in memory.

/// Column i, row j stands at world (x0 + i * cell, y0 - j * cell): north (+y) is up, cell (0,0) is the top-left centre.
struct MapGeometry {
  double x0 = 0, y0 = 0, cell = 0;  ///< strip units
  std::int32_t columns = 0, rows = 0;
};

/// A part of a map, all rasters of one size.
struct MapTile {
  std::int32_t column = 0, row = 0;    ///< of its first cell in the map
  host::Raster<float> height;          ///< world z; NaN where nothing was seen
  host::Raster<float> sigma;           ///< one sigma of the height, from matching; NaN where it is unknown
  host::Raster<std::uint8_t> ortho;    ///< grey value seen from above; 0 where nothing was seen
  host::Raster<std::uint16_t> count;   ///< keyframes whose surface covers the cell
  host::Raster<std::uint16_t> source;  ///< 1 + place in the strip's keyframes of the one that is shown; 0: none
  LaidGround laid;
};

struct Mosaic {
  MapGeometry geometry;
  std::int32_t tile_columns = 0, tile_rows = 0;  ///< tiles lie side by side and cover the map
  /// None for a tile without any data. Several threads may call it at once.
  std::function<std::optional<MapTile>(std::int32_t tile_column, std::int32_t tile_row)> tile;
  /// Tile (i, j) has the cells from column left + i * tile_side and row top + j * tile_side on, as far as they are in
  /// the map: left and top are 0 or less.
  std::int32_t tile_side = 0, left = 0, top = 0;
  /// Of all that a tile depends on; none for a tile without any data. The function may be empty.
  std::function<std::optional<std::uint64_t>(std::int32_t tile_column, std::int32_t tile_row)> digest;
  HeightErrors errors;  ///< of the heights, beside those of matching
};

}  // namespace ilp::map
