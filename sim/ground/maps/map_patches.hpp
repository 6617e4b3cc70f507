// Patches of ground from which a map is made: light and heights. They come from an orbiter's rasters or from a
// simulated world.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>

#include "fsw/maps/map_directory.hpp"
#include "sim/host/raster.hpp"

namespace ilp::maps {

/// Value of unknown light and heights.
inline constexpr float not_known = std::numeric_limits<float>::quiet_NaN();

/// A rectangle of cells of a layer. All members are multiples of map_post_spacing; the first column and row may be
/// negative.
struct PatchArea {
  std::int32_t first_column = 0, first_row = 0, columns = 0, rows = 0;
};

struct MapPatch {
  host::Raster<float> light;  ///< one value per cell; 1: level ground of mean brightness; NaN: unknown
  /// Heights in m at corners of cells, map_post_spacing cells apart; size (columns / 4 + 1) x (rows / 4 + 1). NaN:
  /// unknown.
  host::Raster<float> posts;
};

/// Makes the patch of an area.
using PatchOf = std::function<MapPatch(const MapLayer& layer, const PatchArea& area)>;

/// Heights in m at the centres of cells, bilinear between the posts; NaN next to an unknown post.
[[nodiscard]] host::Raster<float> heights_of_cells(const host::Raster<float>& posts, std::int32_t columns,
                                                   std::int32_t rows);

struct Sun {
  double azimuth_rad = 0, elevation_rad = 0;  ///< of the sun: from x (east) towards y (north); above the horizon
  double ambient = 0;                         ///< share of the light on level ground that comes from the whole sky
};
/// From an azimuth clockwise from north, and an elevation above the horizon, in degrees. Throws std::runtime_error
/// whose message begins with `option` if the sun is not above the horizon.
[[nodiscard]] Sun sun_of(const char* option, double azimuth_deg, double elevation_deg, double ambient);

/// Ratio of the light on sloping ground to that on level ground by Lambert's law: ambient + (1 - ambient) max(n s, 0) /
/// sin(elevation), with the normal n from the neighbouring cells and the sun's direction s. NaN where the slope is
/// unknown.
[[nodiscard]] host::Raster<float> shading_of(const host::Raster<float>& heights, double pixel_m, const Sun& sun);

/// Below this shading, the image says little about the ground.
inline constexpr float least_shading = 0.15F;

/// Divides the light by the shading, but at least by least_shading. Cells with unknown shading do not change.
void flatten(host::Raster<float>& light, const host::Raster<float>& shading);

/// Roughness of the light: sum of squared differences between cells map_post_spacing apart, over cells with known light
/// and shading.
[[nodiscard]] double roughness_of(const host::Raster<float>& light, const host::Raster<float>& shading);

}  // namespace ilp::maps
