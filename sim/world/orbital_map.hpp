// A simulated world as an orbiter maps it: an orthoimage and a terrain model with their errors, under the sun of
// another day.
#pragma once

#include <cstdint>

#include "sim/host/raster.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

struct OrbitalMapParams {
  double pixel_m = 1;           ///< of the image; more than half a post of the world
  double spread_px = 0.5;       ///< sigma of the point spread
  double noise = 0.03;          ///< of the image, one sigma, as a share of the light on level ground
  double height_sigma_m = 0.3;  ///< of the heights: an error that changes smoothly over some posts
  std::uint32_t seed = 1;       ///< of both errors
};

/// Cells count from the north-western corner: pixel (column, row) has its centre at x = west + (column + 0.5) pixel,
/// y = north - (row + 0.5) pixel. Posts stand at corners of pixels, map_posts_apart pixels apart.
inline constexpr std::int32_t map_posts_apart = 4;
struct OrbitalMap {
  host::Raster<float> light;    ///< 1: level ground of mean albedo
  host::Raster<float> heights;  ///< m; columns / 4 + 1 by rows / 4 + 1 posts, each the mean over a square of 4 pixels
};

/// `columns` and `rows` are multiples of 64. The terrain has the sun of the image. Pixel and post at a place have the
/// same errors in every map with this corner. std::invalid_argument for parameters out of their range.
[[nodiscard]] OrbitalMap render_orbital_map(const Terrain& terrain, double west_m, double north_m, std::int32_t columns,
                                            std::int32_t rows, const OrbitalMapParams& params);

}  // namespace ilp::world
