// Opens the video camera at start-up and prints the verdict on its driver.
#pragma once

#include "hal/camera/v4l2/v4l2_camera.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

/// Opens the device of `settings` (parse_v4l2_options) for pictures of `width` x `height` px. Waits up to five seconds
/// for the verdict on the driver and prints it on standard error. Returns ok also if the camera is absent or not ready,
/// because the flight tries again. Returns an error of parse_v4l2_options(), or the reason if the camera cannot deliver
/// such pictures (is_refusal); a wrong pixel format is explained on standard error.
Status start_video_camera(const char* settings, std::int32_t width, std::int32_t height, const RealClock& clock,
                          V4l2Camera& camera);

/// Reads the size to which the device of `settings` is set at present, px. Returns errors of parse_v4l2_options() and
/// present_size().
Status find_video_size(const char* settings, VideoDevice& device, std::int32_t& width, std::int32_t& height);

}  // namespace ilp
