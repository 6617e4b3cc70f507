// Loads final poses and points of a few keyframes from the store as a window of bundle adjustment, and the motion of
// their images during the readout.
#pragma once

#include <span>

#include "fsw/vision/calibration/intrinsics_equations.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Loads the cameras of `keyframe_ids` (ascending, with final poses) as free cameras, and the points that at least two
/// of them see, from the structure records up to keyframe `through_id`. Points beyond the window's capacity are left
/// out. Returns `invalid_argument` for more keyframes than limits::max_bundle_cameras, and `truncated` for a structure
/// that ends within a point.
Status load_final_window(Reader<PoseRecord, StructureRecord> store, const CameraModel& camera,
                         std::span<const std::int64_t> keyframe_ids, std::int64_t through_id, BundleProblem& window);

/// Loads the motion of the keyframes' images during the readout of the rolling shutter of `camera`. `readout_open` says
/// that the readout time is an unknown of the adjustment. The motion of a keyframe without a record is unknown.
Status load_motion(Reader<ShutterRecord> store, const CameraModel& camera, bool readout_open,
                   std::span<const std::int64_t> keyframe_ids, WindowMotion& motion);

}  // namespace ilp
