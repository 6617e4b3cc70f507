// What the errors of a rolling shutter's motion add to the estimated error of a pose. All matches of an image share its
// error, so that their scatter does not show it.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Of the two images whose distance is the unit of a strip: what moves the first camera moves all others, and the first
/// baseline gives the track its length.
struct BaselineErrors {
  double first = 0;   ///< of the first image, as a turn, rad
  double length = 0;  ///< of both images together, over the length of the baseline
};

/// Of the strip of `pose`. Nothing changes once the strip's first keyframes are no longer on record.
Status find_baseline_errors(Reader<ShutterRecord, StripRecord, PoseRecord> store, const CameraRecord& camera,
                            const PoseRecord& pose, BaselineErrors& errors);

/// Adds to sigma and covariance what the own image and those of the baseline cost. A turn costs a place at the distance
/// of the ground. The first camera is the gauge and has no error.
void add_errors(double own_rad, const BaselineErrors& baseline, PoseRecord& pose);

}  // namespace ilp
