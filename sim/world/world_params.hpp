// What a simulated world looks like. The defaults suit a camera of 0.1 to 0.3 m ground pixels; another altitude wants
// the lengths scaled with it.
#pragma once

#include <cstdint>

namespace ilp::sim {

struct WorldParams {
  std::uint64_t seed = 1;  ///< another seed is another place

  // Fractal ground: octaves of gradient noise, amplitude proportional to wavelength^hurst
  double relief_m = 12;                ///< typical highest minus lowest point of a flight; heights stay inside +-relief
  double longest_wavelength_m = 160;   ///< of the fractal ground
  double shortest_wavelength_m = 0.6;  ///< of the fractal ground; at least two post spacings
  double hurst = 0.85;                 ///< 1: equally steep at every scale, lower: rougher
  double post_spacing_m = 0.2;         ///< the ground is bilinear between posts

  // Craters: size classes, each half as large as the one before and four times as many
  double largest_crater_radius_m = 18;
  double smallest_crater_radius_m = 1.2;
  double crater_density = 0.6;  ///< 0 to 1: chance of one in a square of 3.2 radii

  // Rocks
  double largest_rock_radius_m = 1.4;
  double smallest_rock_radius_m = 0.35;
  double rock_density = 0.5;  ///< 0 to 1: chance of one in a square of 6 radii, where the ground is rocky

  // Light and surface
  double sun_azimuth_rad = 2.2;     ///< direction towards the sun, from x towards y
  double sun_elevation_rad = 0.55;  ///< above the horizon
  double ambient = 0.25;            ///< share of the light on level ground that comes from the whole sky
  double albedo_contrast = 0.6;     ///< strength of the surface's brightness variations
};

}  // namespace ilp::sim
