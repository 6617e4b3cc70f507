// The camera that windows of keyframes ask for, from what was known of it before: a Gauss-Newton step in its seven
// intrinsics.
#pragma once

#include "fsw/vision/calibration/camera_check.hpp"

namespace ilp {

/// A camera as it was before an image was seen, and one sigma of each intrinsic.
struct LensPrior {
  CameraModel camera;
  Intrinsics sigmas{};
};
/// A camera with this relative error of its focal length, whose lens nobody has calibrated.
[[nodiscard]] LensPrior prior_of(const CameraModel& nominal, double focal_sigma);

struct LensStep {
  CameraModel camera;      ///< after the step
  double length = 0;       ///< largest component, in sigmas
  bool shortened = false;  ///< one step may only go so far
  Intrinsics sigmas{};
  std::array<double, intrinsic_count*(intrinsic_count + 1) / 2> covariance{};  ///< lower triangle; px for the first 3
  double lens_sigma = 0;  ///< of k1, if the focal length were known
};
/// `evidence` was taken at the camera `now`. What no lens explains of it, `misfit` times as much as its errors in
/// squares, makes it count so much less.
[[nodiscard]] LensStep step_towards_lens(const CameraEvidence& evidence, const CameraModel& now, const LensPrior& prior,
                                         double misfit);

}  // namespace ilp
