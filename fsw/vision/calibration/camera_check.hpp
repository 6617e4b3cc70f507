// Whether the images of a strip fit its camera: the evidence of all windows, and the verdict on it.
#pragma once

#include <cmath>

#include "fsw/vision/calibration/intrinsics_equations.hpp"

namespace ilp {

/// Limits of CameraCheck: of the statistic, of which the right camera has had 2.1 at most, of spread, and of field.
inline constexpr double max_camera_statistic = 2.5, max_camera_spread = 2, max_camera_field = 1.6;

/// Sums over the windows of a strip.
struct CameraEvidence {
  std::array<double, camera_unknowns*(camera_unknowns + 1) / 2> information{};  ///< lower triangle
  CameraUnknowns gradient{};
  std::array<double, camera_unknowns*(camera_unknowns + 1) / 2> displacement{};  ///< sum over the windows
  double gained = 0;  ///< of each window by its own correction
  double noise2_px = 0;
  std::uint32_t windows = 0, points = 0;
  ResidualField field;
};
/// A window with too few points adds nothing.
void add_window(const IntrinsicsEquations& window, CameraEvidence& evidence);

struct CameraCheck {
  CameraCheckVerdict verdict = CameraCheckVerdict::nothing_seen;
  /// g^T I^-1 g over the number of unknowns, I and g the summed information and gradient.
  double statistic = 0;
  /// Heterogeneity of the windows: their own gains less that of the sum, per degree of freedom; 0 for one window.
  double spread = 0;
  /// Root mean square of the mean residuals of the image's parts over what the residuals' scatter explains, after each
  /// window's own correction: 1 where nothing is systematic.
  double field = 0;
  double noise_px = 0;
  /// What the images ask for, all unknowns together, and one sigma; a direction that they do not determine stays at
  /// usual_errors.
  CameraUnknowns corrections{}, sigmas{};
  /// The intrinsic that alone explains most, its correction, and that over its sigma.
  Intrinsic worst = Intrinsic::focal_length;
  double worst_correction = 0, worst_sigmas = 0;
  /// How far the corrections move the camera centres, a share of the track: root mean square over the windows.
  double cost = 0;
};
/// How far the images are from fitting any lens: spread or field over what it may be, whichever is larger. Above 1 they
/// fit none. A large statistic allows more: one step finds a large correction only roughly, which leaves something in
/// windows and residuals.
struct LensExcess {
  double of_spread = 0, of_field = 0;

  [[nodiscard]] double largest() const { return std::fmax(of_spread, of_field); }
};
[[nodiscard]] LensExcess excess_of(double statistic, double spread, double field);

[[nodiscard]] CameraCheck judge(const CameraEvidence& evidence, const CameraModel& given);

}  // namespace ilp
