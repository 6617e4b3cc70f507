// What a map is made from, piece by piece, whatever it comes from: rasters of an orbiter, or a simulated world.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>

#include "fsw/maps/map_directory.hpp"
#include "sim/host/raster.hpp"

namespace ilp::maps {

/// Of light and heights.
inline constexpr float not_known = std::numeric_limits<float>::quiet_NaN();

/// Cells of a layer: `columns` x `rows` from (first_column, first_row) on, all multiples of map_post_spacing; the first
/// ones may be negative.
struct PatchArea {
  std::int32_t first_column = 0, first_row = 0, columns = 0, rows = 0;
};

struct MapPatch {
  host::Raster<float> light;  ///< of the cells, 1 on level ground of mean brightness; NaN: unknown
  /// m, at the corners of cells, map_post_spacing cells apart: columns / 4 + 1 by rows / 4 + 1; NaN: unknown.
  host::Raster<float> posts;
};

using PatchOf = std::function<MapPatch(const MapLayer& layer, const PatchArea& area)>;

/// Metres at the centres of cells, bilinear between the posts; NaN beside unknown ones.
[[nodiscard]] host::Raster<float> heights_of_cells(const host::Raster<float>& posts, std::int32_t columns,
                                                   std::int32_t rows);

struct Sun {
  double azimuth_rad = 0, elevation_rad = 0;  ///< towards it, from x to y; above the horizon
  double ambient = 0;
};
/// From degrees, clockwise from north and above the horizon, as people give them. std::runtime_error begins with
/// `option` where the numbers are none of a sun above the horizon.
[[nodiscard]] Sun sun_of(const char* option, double azimuth_deg, double elevation_deg, double ambient);

/// Light of a sun on the ground by Lambert's law, over that of level ground: ambient + (1 - ambient) max(n s, 0) / sin
/// of its elevation, with the slope over the two neighbours of a cell. NaN where the slope is unknown.
[[nodiscard]] host::Raster<float> shading_of(const host::Raster<float>& heights, double pixel_m, const Sun& sun);

/// Below this shading, the image says little about the ground.
inline constexpr float least_shading = 0.15F;

/// Divides the light by the shading where that is known.
void flatten(host::Raster<float>& light, const host::Raster<float>& shading);

/// How rough light is: the sum of its squared changes from post to post, where it is known and so is the shading.
[[nodiscard]] double roughness_of(const host::Raster<float>& light, const host::Raster<float>& shading);

}  // namespace ilp::maps
