// Adds the effect of errors of the rolling shutter's motion to the estimated error of a pose. All matches of an image
// have this error in common, so that their scatter does not show it.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Errors of the first two images of a strip, which define its world frame and its unit (the first baseline).
struct BaselineErrors {
  double first = 0;   ///< rotation error of the first image, rad; it moves all later cameras
  double length = 0;  ///< error of both images together, divided by the length of the baseline: error of the unit
};

/// Finds the errors for the strip of `pose`. `errors` is unchanged if the strip's first keyframes are not on record any
/// more.
Status find_baseline_errors(Reader<ShutterRecord, StripRecord, PoseRecord> store, const CameraRecord& camera,
                            const PoseRecord& pose, BaselineErrors& errors);

/// Adds the errors of the keyframe's own image (`own_rad`, shutter_error_rad) and of the baseline's images to sigma and
/// covariance of `pose`. A rotation error displaces the camera by this angle times the distance of the ground. Zeros
/// stay zero: the first camera is the gauge and has no error.
void add_errors(double own_rad, const BaselineErrors& baseline, PoseRecord& pose);

}  // namespace ilp
