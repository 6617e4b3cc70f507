// Images and maps between the store and a component's own buffers.
#pragma once

#include "hal/camera/camera.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// `not_found` when the frame, or its image, has been released.
Status load_frame_image(Store& store, std::int64_t frame_id, FrameImage& image);
Status load_keyframe_image(Store& store, std::int64_t keyframe_id, FrameImage& image);

}  // namespace ilp
