// What the errors of a rolling shutter's motion add to the stated error of a pose. All matches of an image share its
// error, so that their scatter does not show it.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The errors of the images' motion as turns, each of which costs a place at the distance of the ground.
struct ShutterErrors {
  double own = 0;     ///< rad
  double first = 0;   ///< of the first image
  double length = 0;  ///< of both images of the first baseline, over its length
};

/// Of the images that are on record; 0 where the strip is not.
Result<ShutterErrors> shutter_errors(Reader<ShutterRecord, StripRecord, PoseRecord> store, const CameraRecord& camera,
                                     const PoseRecord& pose);

/// Adds them to sigma and covariance. The first camera is the gauge and has no error: what moves it moves all others,
/// and the first baseline gives the track its length.
void add_errors(const ShutterErrors& errors, PoseRecord& pose);

}  // namespace ilp
