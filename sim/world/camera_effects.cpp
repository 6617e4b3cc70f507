#include "sim/world/camera_effects.hpp"

#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

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
      {"settable_us", &e.settable_us, "us",
       "exposure at which level ground of mean albedo is grey 127, of a camera that can be set; 0: it cannot", 0, 1e6},
      {"first_us", &e.first_us, "us", "exposure with which such a camera begins; 0: that of settable_us", 0, 1e6},
      {"obeys_after", &e.obeys_after, "", "images that such a camera takes before a new setting acts", 0, 1e6},
      {"light_from_s", &e.light_from_s, "s", "time at which the light changes first", 0, 1e8},
      {"light_for_s", &e.light_for_s, "s", "time for which it is changed; 0: never", 0, 1e8},
      {"light_every_s", &e.light_every_s, "s", "time from one change to the next; 0: only one", 0, 1e8},
      {"light_share", &e.light_share, "", "factor on the light then", 0, 100},
      {"saturates", &e.saturates, "", "grey is proportional to the light and ends at white"},
      {"cloud_from_s", &e.cloud_from_s, "s", "time at which the first cloud comes below the camera", 0, 1e8},
      {"cloud_for_s", &e.cloud_for_s, "s", "time for which each cloud stays; 0: no clouds", 0, 1e8},
      {"cloud_every_s", &e.cloud_every_s, "s", "time from one cloud to the next; 0: only one cloud", 0, 1e8},
      {"cloud_opacity", &e.cloud_opacity, "",
       "share of the ground's light that a cloud replaces by even light; 1 hides the ground", 0, 1},
  };
}

namespace {

/// Whether a time is in a window that begins `from_s`, lasts `for_s` and comes again `every_s` (0: once).
bool inside(double from_s, double for_s, double every_s, std::int64_t time_ns) {
  const double since_s = 1e-9 * static_cast<double>(time_ns) - from_s;
  if (since_s < 0) return false;
  const double passed_s = every_s > 0 ? since_s - every_s * std::floor(since_s / every_s) : since_s;
  return passed_s < for_s;
}

}  // namespace

double cloud_at(const CameraEffects& effects, std::int64_t time_ns) {
  return inside(effects.cloud_from_s, effects.cloud_for_s, effects.cloud_every_s, time_ns) ? effects.cloud_opacity : 0;
}

double light_at(const CameraEffects& effects, std::int64_t time_ns) {
  return inside(effects.light_from_s, effects.light_for_s, effects.light_every_s, time_ns) ? effects.light_share : 1;
}

CameraEffects exposed_with(const CameraEffects& effects, double exposure_us, double gain, double light) {
  CameraEffects one = effects;
  one.saturates = true;
  one.exposure_s = 1e-6 * exposure_us;
  one.gain = effects.gain * light * gain * exposure_us / effects.settable_us;
  // At a higher gain, white is reached by fewer electrons, and the noise before the amplifier grows with it.
  one.full_well_e = effects.full_well_e / gain;
  one.read_noise_grey = effects.read_noise_grey * gain;
  return one;
}

Haze::Haze(double share, double scale_height_m, double camera_z_m)
    : scale_height_m_(scale_height_m), camera_z_m_(camera_z_m) {
  per_density_m_ = -det_log(1 - share) / (camera_z_m * mean_density(0));
}

double Haze::mean_density(double z_m) const {
  if (scale_height_m_ <= 0) return 1;
  const double column = (camera_z_m_ - z_m) / scale_height_m_;
  return (det_exp(-z_m / scale_height_m_) - det_exp(-camera_z_m_ / scale_height_m_)) / column;
}

double Haze::transmission(double z_m, double path_m) const {
  return det_exp(-per_density_m_ * mean_density(z_m) * path_m);
}

CameraState state_after(const CameraMotion& motion, double seconds) {
  CameraState state = motion.state;
  state.centre += seconds * motion.velocity_m_s;
  state.rotation = rotation_from_vector(seconds * motion.turn_rad_s) * motion.state.rotation;
  return state;
}

double row_time_s(const CameraEffects& effects, std::int32_t row, std::int32_t rows) {
  return effects.readout_s * (row / static_cast<double>(rows - 1) - 0.5);
}

}  // namespace ilp::world
