// How probable it is that a lander is safe at each place of a map, and the best places.
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
  double footprint_m = 0;
  double slope_rad = 0;
  double step_m = 0;
};

/// "10" or "10,12,0.5": diameter of the footprint in m, steepest slope in degrees (default 10) and largest step in m
/// (default a tenth of the footprint). std::runtime_error says what is wrong and which values are possible.
[[nodiscard]] LandingLimits read_landing_limits(const std::string& text);

/// The probability that the plane of the footprint is steeper than the gradient `limit`: its gradient has independent
/// normal errors of one sigma `sigma` in both components. Exact to 5e-4; small values keep their digits.
[[nodiscard]] double steep_probability(double gradient, double sigma, double limit);

/// The probability that the true step is more than `limit_m`, by the measured one and the rms error of the heights. The
/// true step is lognormal. Noise has raised the measured one, in quadrature, and matching has lowered what stands out;
/// both differ from ground to ground, the more the fewer cells the footprint has across. landing-sites.md has the
/// comparison with true ground behind the numbers.
[[nodiscard]] double uneven_probability(double step_m, double sigma_m, double limit_m, double cells_across);
inline constexpr double noise_range = 2.5;    ///< of the heights of flat ground, in one-sigma errors of a height
inline constexpr double lowered_cells = 4.5;  ///< the true step exceeds the measured one by this over the cells across
inline constexpr double step_log_variance = 1.9;  ///< of the logarithm of the true step, times the cells across
inline constexpr double step_noise = 0.8;         ///< one sigma of the same by noise, times step over error of a height

struct LandingSite {
  std::int32_t column = 0, row = 0;  ///< of LandingMap::hazards
  double x = 0, y = 0, z = 0;        ///< middle of the footprint in the strip's world, strip units
  double slope_rad = 0, roughness_m = 0, step_m = 0;
  double safe = 0;  ///< probability
};

/// Of a strip: hazards, probability and sites.
struct LandingMap {
  LandingLimits limits;
  double metres_per_unit = 1;
  double tilt_sigma_rad = 0;  ///< one sigma of what is up, about each horizontal axis
  FootprintHazards hazards;
  host::Raster<float> slope_rad;
  host::Raster<float> safe;        ///< probability; NaN where the footprint is not covered
  std::vector<LandingSite> sites;  ///< the best first
};

/// At most this many sites, none nearer to another than a footprint, none less probable.
inline constexpr std::size_t most_sites = 10;
inline constexpr double least_safe = 0.999;

/// Throws as footprint_hazards does, and where the step is lower than what the map can show.
[[nodiscard]] LandingMap assess_landing(const map::GroundGrid& grid, double metres_per_unit, double tilt_sigma_rad,
                                        const LandingLimits& limits);

}  // namespace ilp::landing
