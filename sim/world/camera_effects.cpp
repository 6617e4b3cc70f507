#include "sim/world/camera_effects.hpp"

namespace ilp::world {

std::vector<Parameter> parameters(CameraEffects& e) {
  return {
      {"vignetting", &e.vignetting, "", "share of light lost in the corners", 0, 0.95},
      {"exposure_s", &e.exposure_s, "s", "exposure time, which causes motion blur", 0, 10},
      {"readout_s", &e.readout_s, "s", "rolling shutter: time from the first row to the last", 0, 10},
      {"psf_sigma_px", &e.psf_sigma_px, "px", "standard deviation of the Gaussian point spread", 0, 20},
      {"gain", &e.gain, "", "factor on the light of the whole flight", 0.01, 100},
      {"gain_step", &e.gain_step, "", "largest relative change of the gain between frames", 0, 0.5},
      {"full_well_e", &e.full_well_e, "electrons", "electrons at grey level 255, for shot noise", 10, 1e7},
      {"shot_noise", &e.shot_noise, "", "images have shot noise"},
      {"read_noise_grey", &e.read_noise_grey, "grey levels", "standard deviation of the read noise", 0, 50},
      {"dead_pixel_share", &e.dead_pixel_share, "", "share of pixels that are stuck", 0, 1},
      {"haze", &e.haze, "", "share of the light from the ground straight below that is replaced by light of the sky", 0,
       0.99},
      {"haze_scale_height_m", &e.haze_scale_height_m, "m", "scale height of the haze; 0: the same density everywhere",
       0, 1e6},
  };
}

}  // namespace ilp::world
