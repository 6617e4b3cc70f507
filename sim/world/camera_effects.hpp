// The effects of a real camera and a real atmosphere on an ideal image. Each effect is off by default and works without
// the others.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/world/camera_state.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {

struct CameraEffects {
  double vignetting = 0;  ///< share of light lost in the farthest corner, by the fourth power of the cosine (lens.hpp)

  double exposure_s = 0;    ///< exposure time, which causes motion blur; 0: no blur
  double readout_s = 0;     ///< rolling shutter: time from the first row to the last; 0: global shutter
  double psf_sigma_px = 0;  ///< sigma of the Gaussian point spread

  double gain = 1;                 ///< factor on the radiance of all frames: exposure time and amplification
  double gain_step = 0;            ///< largest relative change of the gain between frames (frame_gain in sensor.hpp)
  double full_well_e = 10000;      ///< electrons at full scale (255), for shot noise
  bool shot_noise = false;         ///< Poisson-like: the variance equals the number of electrons
  double read_noise_grey = 0;      ///< standard deviation, grey levels
  double dead_pixel_share = 0;     ///< share of pixels that are stuck at a constant level, the same in every frame
  double haze = 0;                 ///< 0 to 1: share of the light from level ground below that the sky's light replaces
  double haze_scale_height_m = 0;  ///< of the haze's density; 0: the same density everywhere

  double settable_us = 0;    ///< settable exposure: value for grey 127 on level ground of mean albedo; 0: not settable
  double first_us = 0;       ///< settable exposure: value at the begin; 0: settable_us
  double obeys_after = 0;    ///< settable exposure: images that are taken before a new setting acts
  double light_from_s = 0;   ///< time of the first change of light
  double light_for_s = 0;    ///< duration of a change; 0: the light never changes
  double light_every_s = 0;  ///< period of the changes; 0: only one
  double light_share = 1;    ///< factor on the light during a change
  bool saturates = false;    ///< grey is proportional to the light up to 255, instead of a curve that stays below 255

  double cloud_from_s = 0;   ///< time of the first cloud below the camera
  double cloud_for_s = 0;    ///< duration of each cloud; 0: no clouds
  double cloud_every_s = 0;  ///< period of the clouds; 0: only one
  double cloud_opacity = 1;  ///< 0 to 1: share of the ground's light that uniform light replaces; 1 hides the ground
};

[[nodiscard]] std::vector<Parameter> parameters(CameraEffects& effects);

// Haze between the ground and the camera, which reduces the contrast with the length of the path (H. Koschmieder's law
// of visibility, 1924: L = L0 e^-tau + sky (1 - e^-tau)). The sky is as bright as level ground of mean albedo.

class Haze {
 public:
  /// `share`, from 0 to below 1, is the share of the light from level ground (z = 0) straight below a camera at
  /// `camera_z_m` that the sky's light replaces. The density is proportional to exp(-z / scale height), or constant for
  /// a scale height of 0.
  Haze(double share, double scale_height_m, double camera_z_m);

  /// Share of the light from a point at height `z_m` and distance `path_m` that reaches the camera.
  [[nodiscard]] double transmission(double z_m, double path_m) const;
  /// The radiance that the camera receives from such a point, with the sky's light.
  [[nodiscard]] double seen(double radiance, double z_m, double path_m) const {
    constexpr double sky = 1;
    return sky + (radiance - sky) * transmission(z_m, path_m);
  }

 private:
  /// Mean density between z and the camera, relative to the density at z = 0.
  [[nodiscard]] double mean_density(double z_m) const;

  double scale_height_m_;
  double camera_z_m_;
  double per_density_m_ = 0;
};

/// Factor on the light at this time: `light_share` during a change, else 1.
[[nodiscard]] double light_at(const CameraEffects& effects, std::int64_t time_ns);

/// Effects for one image of a camera with settable exposure. `light` is the factor of light_at.
[[nodiscard]] CameraEffects exposed_with(const CameraEffects& effects, double exposure_us, double gain, double light);

/// Share of the ground's light that a cloud replaces at this time; 0 without a cloud.
[[nodiscard]] double cloud_at(const CameraEffects& effects, std::int64_t time_ns);

// Times of exposure and camera states for rolling shutter and motion blur.

/// The state `seconds` after motion.state for constant rates. time_ns is not changed.
[[nodiscard]] CameraState state_after(const CameraMotion& motion, double seconds);

/// Time in s from the middle of the exposure of the image's middle row to that of the given row.
[[nodiscard]] double row_time_s(const CameraEffects& effects, std::int32_t row, std::int32_t rows);

}  // namespace ilp::world
