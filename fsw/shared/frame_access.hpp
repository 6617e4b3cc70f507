// Images, camera and maps between the store and a component's own buffers.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/camera/camera.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// `not_found` when the frame, or its image, has been released.
Status load_frame_image(Reader<FrameRecord> store, std::int64_t frame_id, FrameImage& image);
/// At the time of the middle row, if the camera has a rolling shutter and the keyframe's motion is on record.
Status load_keyframe_image(Reader<KeyframeRecord, FrameRecord, CameraRecord, ShutterRecord> store,
                           std::int64_t keyframe_id, FrameImage& image);

/// The present camera. Only a frozen one gives metric results.
Status load_camera(Reader<CameraRecord> store, CameraModel& camera);

/// Brings the image of a keyframe to the time of its middle row. False where the motion is not known, or too fast: the
/// image is as it was read.
Result<bool> bring_to_middle_row(const CameraModel& camera, const ShutterRecord& shutter, FrameImage& image);

}  // namespace ilp
