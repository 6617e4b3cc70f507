// Renders a simulated world as an orbiter's map: an orthoimage and a terrain model with errors. The sun may differ from
// the flight's.
#pragma once

#include <cstdint>

#include "sim/host/raster.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

struct OrbitalMapParams {
  double pixel_m = 1;           ///< pixel size; more than half of the world's post spacing
  double spread_px = 0.5;       ///< sigma of the point spread
  double noise = 0.03;          ///< one sigma of the image's noise, share of the light on level ground
  double height_sigma_m = 0.3;  ///< one sigma of the height error, which is smooth over some posts
  std::uint32_t seed = 1;       ///< of noise and height error
};

/// Columns and rows count from the north-western corner (west_m, north_m). The centre of pixel (column, row) is at x =
/// west_m + (column + 0.5) pixel_m, y = north_m - (row + 0.5) pixel_m. Posts of heights are at pixel corners,
/// map_posts_apart pixels apart, from the north-western corner on.
inline constexpr std::int32_t map_posts_apart = 4;
struct OrbitalMap {
  host::Raster<float> light;    ///< 1: level ground of mean albedo
  host::Raster<float> heights;  ///< m; columns / 4 + 1 by rows / 4 + 1 posts, each the mean over a square of 4 pixels
};

/// Renders a map of `columns` x `rows` pixels, which are multiples of 64. The light is that of the terrain's sun. Maps
/// with the same corner have the same errors at the same positions. Throws std::invalid_argument for parameters out of
/// range.
[[nodiscard]] OrbitalMap render_orbital_map(const Terrain& terrain, double west_m, double north_m, std::int32_t columns,
                                            std::int32_t rows, const OrbitalMapParams& params);

}  // namespace ilp::world
