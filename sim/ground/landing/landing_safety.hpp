// Estimates the probability of a safe landing at each point of a map, and finds the best landing sites.
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/landing/footprint_hazards.hpp"

namespace ilp::landing {

inline constexpr double degree = std::numbers::pi / 180;  ///< rad

struct LandingLimits {
  double footprint_m = 0;  ///< diameter of the lander's footprint
  double slope_rad = 0;    ///< steepest safe slope
  double step_m = 0;       ///< largest safe step
};

/// Parses "10" or "10,12,0.5": diameter of the footprint in m, steepest slope in degrees (default 10) and largest step
/// in m (default a tenth of the footprint). Throws std::runtime_error that says what is wrong and which values are
/// possible.
[[nodiscard]] LandingLimits read_landing_limits(const std::string& text);

/// The probability that the true gradient of the footprint's plane is steeper than `limit`. `gradient`: measured, with
/// independent normal errors of standard deviation `sigma` in both components. Absolute error up to 5e-4; small values
/// are accurate relatively.
[[nodiscard]] double steep_probability(double gradient, double sigma, double limit);

/// The probability that the true step exceeds `limit_m`, from the measured step and the RMS error `sigma_m` of the
/// heights. The true step is modelled as lognormal. Noise increases the measured step in quadrature, and matching
/// flattens what stands out of the plane. Both effects vary with the ground, the more the fewer cells the footprint has
/// across. landing-sites.md has the comparison with true ground from which the constants come.
[[nodiscard]] double uneven_probability(double step_m, double sigma_m, double limit_m, double cells_across);
inline constexpr double noise_range = 2.5;        ///< step measured on flat ground, in standard deviations of a height
inline constexpr double lowered_cells = 4.5;      ///< true step = measured * (1 + lowered_cells / cells_across)
inline constexpr double step_log_variance = 1.9;  ///< variance of the true step's logarithm, times cells_across
inline constexpr double step_noise = 0.8;         ///< sigma of the logarithm from noise = step_noise * sigma_m / step

struct LandingSite {
  std::int32_t column = 0, row = 0;  ///< in the rasters of LandingMap
  double x = 0, y = 0, z = 0;        ///< centre of the footprint in the strip's world, strip units
  double slope_rad = 0, roughness_m = 0, step_m = 0;
  double safe = 0;  ///< probability of a safe landing
};

/// Hazards, probabilities and landing sites of a strip. The rasters have the geometry of `hazards`.
struct LandingMap {
  LandingLimits limits;
  double metres_per_unit = 1;
  double tilt_sigma_rad = 0;  ///< standard deviation of the vertical, about each horizontal axis
  FootprintHazards hazards;
  host::Raster<float> slope_rad;
  host::Raster<float> safe;        ///< probability of a safe landing; NaN where heights do not cover the footprint
  std::vector<LandingSite> sites;  ///< the best first; centres at least a footprint apart
};

/// Largest number of sites, and lowest probability of a site.
inline constexpr std::size_t most_sites = 10;
inline constexpr double least_safe = 0.999;

/// Computes the landing map of a strip. Throws as footprint_hazards does, and throws std::runtime_error if no footprint
/// is covered, or the map cannot resolve the limit's step.
[[nodiscard]] LandingMap assess_landing(const map::GroundGrid& grid, double metres_per_unit, double tilt_sigma_rad,
                                        const LandingLimits& limits);

}  // namespace ilp::landing
