// Computes the hazards of a lander's footprint at each point of a map: slope with its error, roughness, and largest
// step.
#pragma once

#include <cstdint>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/host/raster.hpp"

namespace ilp::landing {

// The hazards are those of ALHAT's hazard detection (A. Johnson et al., "Analysis of On-Board Hazard Detection and
// Avoidance for Safe Lunar Landing", IEEE Aerospace Conference 2008): the plane of the footprint, and deviations from
// it. Ground that was not seen is a hazard.

struct Footprint {
  double diameter_m = 0;  ///< diameter of the circle that the lander may touch
  double metres_per_unit = 1;
  /// Smallest share of the circle's cells that must have a height.
  double least_cover = 0.95;
};

/// Rasters with one cell for each footprint centre, in `geometry` (strip units). NaN where the centre has no height or
/// heights do not cover the circle.
struct FootprintHazards {
  map::MapGeometry geometry;
  std::int32_t stride = 1;             ///< distance of neighbouring centres, cells of the map
  host::Raster<float> gradient_x;      ///< dz/dx of the least-squares plane through the circle, dimensionless
  host::Raster<float> gradient_y;      ///< dz/dy of the plane
  host::Raster<float> gradient_sigma;  ///< standard deviation of each gradient component, from errors of heights alone
  host::Raster<float> roughness_m;     ///< RMS deviation of the heights from the plane, along z
  host::Raster<float> step_m;          ///< largest minus smallest deviation
  host::Raster<float> sigma_m;         ///< RMS of the heights' standard deviations in the circle
};

/// Computes the hazards from the heights of `grid` and their sigma from matching; the median replaces an unknown sigma.
/// Centres are a sixteenth of the diameter apart, but at least one cell. Throws std::runtime_error if the diameter is
/// less than five cells (with the smallest possible one), or no height has a known error.
[[nodiscard]] FootprintHazards footprint_hazards(const map::GroundGrid& grid, const Footprint& footprint);

/// Number of cells that share an error of matching, because of the matching window and smoothing.
inline constexpr double cells_per_error = 40;

}  // namespace ilp::landing
