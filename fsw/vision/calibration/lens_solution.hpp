// Estimates a camera from the evidence of windows of keyframes and from prior knowledge: one Gauss-Newton step in its
// seven intrinsics and its readout time.
#pragma once

#include "fsw/vision/calibration/camera_check.hpp"

namespace ilp {

/// The camera before the first image, and the standard deviation of each unknown; 0: exactly known.
struct LensPrior {
  CameraModel camera;
  CameraUnknowns sigmas{};
};
/// Prior knowledge of a camera, before the first image.
struct KnownOfCamera {
  double focal_sigma = 0;  ///< relative standard deviation of the focal length
  bool lens = false;       ///< focal length, principal point and distortion are known
  double readout_sigma_s = 0;
};
/// The prior of a nominal camera. Principal point and distortion of an unknown lens have the standard deviations of
/// usual_errors().
[[nodiscard]] LensPrior prior_of(const CameraModel& nominal, const KnownOfCamera& known);

struct LensStep {
  CameraModel camera;      ///< after the step
  double length = 0;       ///< largest component before shortening, in standard deviations
  bool shortened = false;  ///< the step was limited, because the equations are linear only nearby
  CameraUnknowns sigmas{};
  std::array<double, camera_unknowns*(camera_unknowns + 1) / 2>
      covariance{};       ///< lower triangle; units: px for the first 3, s for the last
  double lens_sigma = 0;  ///< standard deviation of k1 if the focal length were known
};
/// Takes one step from the camera `now`, at which `evidence` was formed. `misfit` is the ratio of the squared residuals
/// that no lens explains to the squared errors of the evidence; if it is above 1, the evidence is divided by it.
[[nodiscard]] LensStep step_towards_lens(const CameraEvidence& evidence, const CameraModel& now, const LensPrior& prior,
                                         double misfit);

}  // namespace ilp
