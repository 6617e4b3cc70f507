// The camera that windows of keyframes ask for, from what was known of it before: a Gauss-Newton step in its seven
// intrinsics and its readout time.
#pragma once

#include "fsw/vision/calibration/camera_check.hpp"

namespace ilp {

/// A camera as it was before an image was seen, and one sigma of each unknown; 0: it is known.
struct LensPrior {
  CameraModel camera;
  CameraUnknowns sigmas{};
};
/// What is known of a camera before an image was seen.
struct KnownOfCamera {
  double focal_sigma = 0;  ///< relative
  bool lens = false;       ///< focal length, principal point and distortion are known
  double readout_sigma_s = 0;
};
/// A lens that is not known is one that nobody has calibrated.
[[nodiscard]] LensPrior prior_of(const CameraModel& nominal, const KnownOfCamera& known);

struct LensStep {
  CameraModel camera;      ///< after the step
  double length = 0;       ///< largest component, in sigmas
  bool shortened = false;  ///< one step may only go so far
  CameraUnknowns sigmas{};
  std::array<double, camera_unknowns*(camera_unknowns + 1) / 2>
      covariance{};       ///< lower triangle; px for the first 3, s for the last
  double lens_sigma = 0;  ///< of k1, if the focal length were known
};
/// `evidence` was taken at the camera `now`. What no lens explains of it, `misfit` times as much as its errors in
/// squares, makes it count so much less.
[[nodiscard]] LensStep step_towards_lens(const CameraEvidence& evidence, const CameraModel& now, const LensPrior& prior,
                                         double misfit);

}  // namespace ilp
