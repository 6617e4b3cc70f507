// Checks whether the images of a strip fit the intrinsics of its camera: sums the evidence of all windows and gives a
// verdict.
#pragma once

#include <cmath>

#include "fsw/vision/calibration/intrinsics_equations.hpp"

namespace ilp {

/// Largest statistic, spread and field of CameraCheck that fit a camera. The statistic of correct cameras has reached
/// 2.1.
inline constexpr double max_camera_statistic = 2.5, max_camera_spread = 2, max_camera_field = 1.6;

/// Sums over the windows of a strip.
struct CameraEvidence {
  std::array<double, camera_unknowns*(camera_unknowns + 1) / 2> information{};  ///< lower triangle
  CameraUnknowns gradient{};
  std::array<double, camera_unknowns*(camera_unknowns + 1) / 2> displacement{};
  double gained = 0;     ///< sum of IntrinsicsEquations::gained
  double noise2_px = 0;  ///< sum of squared noise_px, px^2
  std::uint32_t windows = 0, points = 0;
  ResidualField field;
};
/// Adds a window to the sums. A window with fewer than 50 points adds nothing.
void add_window(const IntrinsicsEquations& window, CameraEvidence& evidence);

struct CameraCheck {
  CameraCheckVerdict verdict = CameraCheckVerdict::nothing_seen;
  /// g^T I^-1 g divided by the number of unknowns, with the summed information I and gradient g.
  double statistic = 0;
  /// Heterogeneity of the windows: the sum of their own gains minus the gain of the common correction, per degree of
  /// freedom. 0 for one window.
  double spread = 0;
  /// RMS of the mean residuals of the image's parts, divided by the value that the scatter of the residuals explains,
  /// after the correction of each window. 1 if nothing is systematic.
  double field = 0;
  double noise_px = 0;  ///< RMS over the windows of IntrinsicsEquations::noise_px
  /// Corrections of all unknowns that the images ask for, and their standard deviations. A direction that the images do
  /// not determine has the standard deviation of usual_errors().
  CameraUnknowns corrections{}, sigmas{};
  /// The intrinsic whose correction alone explains most, this correction, and its ratio to its standard deviation.
  Intrinsic worst = Intrinsic::focal_length;
  double worst_correction = 0, worst_sigmas = 0;
  /// RMS over the windows of the displacement of the camera centres by the corrections, as a share of the track's
  /// extent.
  double cost = 0;
};
/// Measures whether any lens fits the images: spread and field, each divided by its largest acceptable value. If one is
/// above 1, no lens fits. A larger statistic raises the acceptable values, because one step finds a large correction
/// only roughly.
struct LensExcess {
  double of_spread = 0, of_field = 0;

  [[nodiscard]] double largest() const { return std::fmax(of_spread, of_field); }
};
[[nodiscard]] LensExcess excess_of(double statistic, double spread, double field);

/// The verdict on the camera `given`, from the evidence of its windows.
[[nodiscard]] CameraCheck judge(const CameraEvidence& evidence, const CameraModel& given);

}  // namespace ilp
