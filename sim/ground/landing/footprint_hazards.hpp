// What a lander's footprint meets at each place of a map: slope, roughness and largest step, each with its error.
#pragma once

#include <cstdint>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/host/raster.hpp"

namespace ilp::landing {

// The hazards are those of ALHAT's hazard detection (A. Johnson et al., "Analysis of On-Board Hazard Detection and
// Avoidance for Safe Lunar Landing", IEEE Aerospace Conference 2008): the plane of the footprint and what stands out of
// it. Ground that was not seen counts as a hazard.

struct Footprint {
  double diameter_m = 0;  ///< of the circle that the lander may touch
  double metres_per_unit = 1;
  /// Smallest share of the circle's cells with a height. Ground without one may hide anything.
  double least_cover = 0.95;
};

/// Rasters over the centres of footprints: `geometry` is in strip units, as that of the map. NaN where the circle is
/// not covered.
struct FootprintHazards {
  map::MapGeometry geometry;
  std::int32_t stride = 1;         ///< cells of the map from centre to centre
  host::Raster<float> gradient_x;  ///< of the plane of least squares through the circle, rise over run
  host::Raster<float> gradient_y;
  host::Raster<float> gradient_sigma;  ///< one sigma of either component, from the heights' errors alone
  host::Raster<float> roughness_m;     ///< rms distance of the heights from the plane, along z
  host::Raster<float> step_m;          ///< highest minus lowest of these distances
  host::Raster<float> sigma_m;         ///< rms one-sigma error of a height in the circle
};

/// Heights are z of `grid`, errors its sigma (where none is known, the median of the others). Centres are at most a
/// sixteenth of the diameter apart. Throws std::runtime_error with the least diameter where the circle has fewer than
/// five cells across, or the map has no errors.
[[nodiscard]] FootprintHazards footprint_hazards(const map::GroundGrid& grid, const Footprint& footprint);

/// Cells of the map that an error of matching spreads over: a window of matching, and what smooths it.
inline constexpr double cells_per_error = 40;

}  // namespace ilp::landing
