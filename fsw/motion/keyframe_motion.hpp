// How the image of a keyframe moves while a rolling shutter reads it, from the frames about it.
//
// Planes between two frames before and two after the keyframe, as the overlap checker measured them, give the image's
// homography over time: the polynomial through them, and its derivative at the keyframe. The middle of an image is that
// of its middle row, so that its shift is free of the readout; the rest is corrected with the motion found so far. No
// focal length, velocity or attitude is needed apart: over a plane a homography holds them all.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

using KeyframeMotionStore = Reader<KeyframeRecord, FrameRecord, StripRecord, OverlapRecord, FramePlaneRecord>;

/// Fills `shutter` for a camera with a rolling shutter, found or to be found, and leaves it empty (id 0) for any other.
/// False while the two frames after the keyframe are not judged and its strip goes on. With fewer frames than two on
/// each side the sigma is larger. Without any, and where the motion is too fast for the correction, the source is
/// `none`.
Result<bool> keyframe_motion(KeyframeMotionStore store, const CameraRecord& camera, const KeyframeRecord& keyframe,
                             ShutterRecord& shutter);

/// One sigma of the motion along x and along y, px/s. Relief disturbs the frames alike, and at the end of a swing they
/// do not say how far they attenuate it: it is larger than that of the record.
[[nodiscard]] double motion_sigma_px_s(const CameraModel& camera, const ShutterRecord& shutter);

/// What the errors of motion and readout time do to a pose, as a turn: root mean square over the rows of how far they
/// move one against the middle row.
[[nodiscard]] double shutter_error_rad(const CameraRecord& camera, const ShutterRecord& shutter);

}  // namespace ilp
