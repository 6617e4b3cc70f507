// Estimates the motion of a keyframe's image during the readout of a rolling shutter, from the neighbouring frames.
//
// The overlap checker has measured homographies between the keyframe and two frames before and two after it. A
// polynomial through them gives the homography over time, and its derivative at the keyframe is the motion. The shift
// of the image centre does not depend on the readout, because the centre is in the middle row; the other elements are
// corrected with the motion found so far. Focal length, velocity and attitude need not be known: over a plane the
// homography contains them.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

using KeyframeMotionStore = Reader<KeyframeRecord, FrameRecord, StripRecord, OverlapRecord, FramePlaneRecord>;

/// Fills `shutter` if the camera has a rolling shutter, with a known or unknown readout time; otherwise leaves it empty
/// (id 0). Returns false while the overlap checker has not judged the two frames after the keyframe and the strip is
/// open. With fewer than two frames on a side the sigma is larger. Without any frame, or if the motion is too fast to
/// be corrected, the source is `none`.
Result<bool> keyframe_motion(KeyframeMotionStore store, const CameraRecord& camera, const KeyframeRecord& keyframe,
                             ShutterRecord& shutter);

/// Standard deviation of the motion in x and in y, px/s. It is larger than ShutterRecord::sigma_px_s, because relief
/// disturbs all frames in the same way, and because the polynomial attenuates the motion at the end of a swing.
[[nodiscard]] double motion_sigma_px_s(const CameraModel& camera, const ShutterRecord& shutter);

/// The effect of the errors of motion and readout time on a pose, as a rotation, rad: the RMS over the rows of a row's
/// displacement relative to the middle row, divided by the focal length.
[[nodiscard]] double shutter_error_rad(const CameraRecord& camera, const ShutterRecord& shutter);

}  // namespace ilp
