// Final poses and points of a few keyframes, read back from the store as a window of bundle adjustment, and how their
// images moved.
#pragma once

#include <span>

#include "fsw/vision/calibration/intrinsics_equations.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Loads the cameras of `keyframe_ids` (ascending, final), all free, and the points that at least two of them see, from
/// the structure up to that of keyframe `through_id`, as far as there is room. `invalid_argument` for more
/// keyframes than limits::max_bundle_cameras, `truncated` for a structure that ends within a point.
Status load_final_window(Reader<PoseRecord, StructureRecord> store, const CameraModel& camera,
                         std::span<const std::int64_t> keyframe_ids, std::int64_t through_id, BundleProblem& window);

/// How the images of these keyframes moved while the rolling shutter of `camera` read them; `readout_open`: its readout
/// time is an unknown. A keyframe without a record has moved in an unknown way.
Status load_motion(Reader<ShutterRecord> store, const CameraModel& camera, bool readout_open,
                   std::span<const std::int64_t> keyframe_ids, WindowMotion& motion);

}  // namespace ilp
