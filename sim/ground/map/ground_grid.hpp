// The elevation map of a strip: as one grid in memory, and in tiles (decisions.md, 8).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/map/height_error.hpp"
#include "sim/host/raster.hpp"

namespace ilp::map {

/// Ground that images show but whose depth was not measured, on interpolated heights (laid_surface in merge.hpp). For
/// pictures only. Each raster is empty or has the map's size.
struct LaidGround {
  host::Raster<float> height;          ///< world z, strip units; NaN: not interpolated, or a height was measured
  host::Raster<std::uint8_t> grey;     ///< 1 to 255; 0: no such ground
  host::Raster<std::uint16_t> source;  ///< as MapTile::source while a tile is painted; empty otherwise
};

/// A map in memory: a regular grid in the strip's world. The centre of column i, row j is at world (x0 + i * cell,
/// y0 - j * cell), so that row 0 is the northern edge (+y).
struct GroundGrid {
  double x0 = 0, y0 = 0, cell = 0;     ///< centre of the top-left cell, and side of a cell; strip units
  host::Raster<float> height;          ///< world z, strip units; NaN: no height
  host::Raster<float> sigma;           ///< standard deviation of the height from matching; NaN: unknown
  host::Raster<float> whole_sigma;     ///< the same with all components (height_error.hpp); empty: not computed
  host::Raster<std::uint8_t> ortho;    ///< grey value of the orthoimage; 0 where nothing was seen
  host::Raster<std::uint16_t> count;   ///< number of keyframes whose surface covers the cell
  host::Raster<std::uint16_t> source;  ///< 1 + index, in the strip's keyframes, of the keyframe shown; 0: none
  LaidGround laid;

  /// `whole_sigma` if it was computed, else `sigma`.
  [[nodiscard]] const host::Raster<float>& estimated_sigma() const { return whole_sigma.empty() ? sigma : whole_sigma; }

  GroundGrid() = default;
  /// A grid without any data.
  GroundGrid(double x, double y, double side, std::int32_t columns, std::int32_t rows);

  [[nodiscard]] double column_of(double x) const { return (x - x0) / cell; }
  [[nodiscard]] double row_of(double y) const { return (y0 - y) / cell; }
};

/// Standard deviation of each cell's height with all components; NaN where the error of matching is unknown.
[[nodiscard]] host::Raster<float> whole_sigma_of(const GroundGrid& grid, const HeightErrors& errors);

/// Median of each component over the cells whose error of matching is known; all 0 if there is no such cell.
[[nodiscard]] HeightErrorParts usual_parts(const GroundGrid& grid, const HeightErrors& errors);

/// z = a x + b y + c.
struct Plane {
  double a = 0, b = 0, c = 0;
  [[nodiscard]] double at(double x, double y) const { return a * x + b * y + c; }
};
/// The plane of least squares through all heights. Pictures show relief above it, because the strip's world need not be
/// level: without navigation its slope depends on the attitude of the first camera.
[[nodiscard]] Plane mean_plane(const GroundGrid& grid);

// A map of any size, of which only one tile at a time is in memory.

/// Position and size of a map's grid, as in GroundGrid.
struct MapGeometry {
  double x0 = 0, y0 = 0, cell = 0;  ///< strip units
  std::int32_t columns = 0, rows = 0;
};

/// A rectangular part of a map. All rasters have one size, and values as in GroundGrid.
struct MapTile {
  std::int32_t column = 0, row = 0;  ///< column and row of its top-left cell in the map
  host::Raster<float> height;
  host::Raster<float> sigma;
  host::Raster<std::uint8_t> ortho;
  host::Raster<std::uint16_t> count;
  host::Raster<std::uint16_t> source;
  LaidGround laid;
};

/// A map that is read tile by tile.
struct Mosaic {
  MapGeometry geometry;
  std::int32_t tile_columns = 0, tile_rows = 0;  ///< number of tiles; they cover the map without overlap
  /// Reads a tile; none for a tile without any data. Several threads may call the function at once.
  std::function<std::optional<MapTile>(std::int32_t tile_column, std::int32_t tile_row)> tile;
  /// Tile (i, j) has tile_side columns from left + i * tile_side and tile_side rows from top + j * tile_side, clipped
  /// to the map. left and top are 0 or negative.
  std::int32_t tile_side = 0, left = 0, top = 0;
  /// Digest of everything that a tile depends on; none for a tile without any data. The function may be empty.
  std::function<std::optional<std::uint64_t>(std::int32_t tile_column, std::int32_t tile_row)> digest;
  HeightErrors errors;  ///< for the components of the heights' errors that do not come from matching
};

}  // namespace ilp::map
