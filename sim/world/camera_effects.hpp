// What a real camera and a real atmosphere do to an ideal image. Every effect is off by default and works alone.
#pragma once

#include <vector>

#include "sim/world/parameter.hpp"

namespace ilp::world {

struct CameraEffects {
  double vignetting = 0;  ///< share of light lost in the image's corners, growing as the fourth power of the cosine

  double exposure_s = 0;    ///< motion blur: the ground moves while the shutter is open; 0: frozen
  double readout_s = 0;     ///< rolling shutter: from the first row to the last
  double psf_sigma_px = 0;  ///< Gaussian point spread

  double gain = 1;                 ///< of the whole flight: exposure time and amplification; multiplies the radiance
  double gain_step = 0;            ///< largest relative change between frames, a smooth random walk within 1/3 to 3
  double full_well_e = 10000;      ///< electrons at full scale (255), for shot noise
  bool shot_noise = false;         ///< Poisson-like, variance equal to the electrons
  double read_noise_grey = 0;      ///< standard deviation, grey levels
  double dead_pixel_share = 0;     ///< stuck at a level of their own, the same ones in every frame
  double haze = 0;                 ///< 0 to 1: share of the light from level ground below that is replaced by the sky's
  double haze_scale_height_m = 0;  ///< of the hazy layer; 0: haze thickens with the distance only
};

[[nodiscard]] std::vector<Parameter> parameters(CameraEffects& effects);

}  // namespace ilp::world
