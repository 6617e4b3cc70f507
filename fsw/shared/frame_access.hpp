// Images, camera and maps between the store and a component's own buffers.
#pragma once

#include "hal/camera/camera.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// `not_found` when the frame, or its image, has been released.
Status load_frame_image(Reader<FrameRecord> store, std::int64_t frame_id, FrameImage& image);
Status load_keyframe_image(Reader<KeyframeRecord, FrameRecord> store, std::int64_t keyframe_id, FrameImage& image);

/// The present camera. Only a frozen one gives metric results.
Status load_camera(Reader<CameraRecord> store, CameraModel& camera);

}  // namespace ilp
