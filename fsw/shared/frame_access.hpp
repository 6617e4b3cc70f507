// Loads images and the camera from the store into a component's buffers.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/camera/camera.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Loads the image of a frame. Returns `not_found` if the frame, or its image, has been released.
Status load_frame_image(Reader<FrameRecord> store, std::int64_t frame_id, FrameImage& image);
/// Loads the image of a keyframe. If the camera has a rolling shutter and the keyframe's motion is on record, the image
/// is corrected to the time of its middle row.
Status load_keyframe_image(Reader<KeyframeRecord, FrameRecord, CameraRecord, ShutterRecord> store,
                           std::int64_t keyframe_id, FrameImage& image);

/// Loads the present camera. Results are metric only if its record is frozen.
Status load_camera(Reader<CameraRecord> store, CameraModel& camera);

/// Corrects the image of a keyframe for the rolling shutter, to the time of its middle row. Returns false and leaves
/// the image unchanged if the motion is not known or too fast.
Result<bool> bring_to_middle_row(const CameraModel& camera, const ShutterRecord& shutter, FrameImage& image);

}  // namespace ilp
