// What a real camera and a real atmosphere do to an ideal image. Every effect is off by default and works alone.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/world/camera_state.hpp"
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

  double settable_us = 0;   ///< exposure at which level ground of mean albedo has grey 127; 0: the flight cannot set it
  double first_us = 0;      ///< exposure with which such a camera begins; 0: settable_us
  double obeys_after = 0;   ///< exposures that such a camera makes before it takes a new setting
  double light_from_s = 0;  ///< time of the first change of light
  double light_for_s = 0;   ///< how long it lasts; 0: the light never changes
  double light_every_s = 0;
  double light_share = 1;  ///< of the light there is then
  bool saturates = false;  ///< grey is proportional to the light and ends at white, instead of a curve that never does

  double cloud_from_s = 0;   ///< time of the first cloud below the camera
  double cloud_for_s = 0;    ///< how long each stays; 0: no clouds
  double cloud_every_s = 0;  ///< after this time the next one comes; 0: there is only one
  double cloud_opacity = 1;  ///< 0 to 1: share of the ground's light that it replaces by even light; 1 hides the ground
};

[[nodiscard]] std::vector<Parameter> parameters(CameraEffects& effects);

// Haze between the ground and the camera: contrast falls with the length of the way through it (H. Koschmieder's law of
// visibility, 1924: L = L0 e^-tau + sky (1 - e^-tau)). The sky's light is that of level ground of mean albedo.

class Haze {
 public:
  /// `share`: of the light from level ground (z = 0) straight below a camera at `camera_z_m` that is replaced by the
  /// sky's, 0 to below 1. Density falls as exp(-z / scale height), or not at all for a scale height of 0.
  Haze(double share, double scale_height_m, double camera_z_m);

  /// Share of the light from the height `z_m` that reaches the camera over `path_m`.
  [[nodiscard]] double transmission(double z_m, double path_m) const;
  /// The part of a radiance that the camera receives.
  [[nodiscard]] double seen(double radiance, double z_m, double path_m) const {
    constexpr double sky = 1;
    return sky + (radiance - sky) * transmission(z_m, path_m);
  }

 private:
  /// Haze in a vertical column from the camera down to z, per metre of the column.
  [[nodiscard]] double mean_density(double z_m) const;

  double scale_height_m_;
  double camera_z_m_;
  double per_density_m_ = 0;
};

/// Share of the light there is at this time, 1 while it is not changed.
[[nodiscard]] double light_at(const CameraEffects& effects, std::int64_t time_ns);

/// The effects of one image that a settable camera takes with this exposure and gain.
[[nodiscard]] CameraEffects exposed_with(const CameraEffects& effects, double exposure_us, double gain, double light);

/// Share of the ground's light that a cloud replaces at this time, 0 without a cloud.
[[nodiscard]] double cloud_at(const CameraEffects& effects, std::int64_t time_ns);

// When a pixel is exposed, and where the camera is then: rolling shutter and motion blur.

/// The state `seconds` after motion.state, at the rates of the motion; time_ns stays.
[[nodiscard]] CameraState state_after(const CameraMotion& motion, double seconds);

/// The middle of a row's exposure, seconds after that of the image's middle row.
[[nodiscard]] double row_time_s(const CameraEffects& effects, std::int32_t row, std::int32_t rows);

}  // namespace ilp::world
