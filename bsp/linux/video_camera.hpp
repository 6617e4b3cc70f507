// The video camera at start-up: settings, self-test, and a report for the person at the bench.
#pragma once

#include "hal/camera/v4l2/v4l2_camera.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

/// `settings` as parse_v4l2_options takes them; the device gives pictures of `width` x `height`. Waits for the verdict
/// on the driver, five seconds at most, and prints it. A camera that is absent or not ready is no error: the flight
/// begins and tries again. A camera that cannot deliver the requested pictures is an error; pixel formats are then
/// named on standard error.
Status start_video_camera(const char* settings, std::int32_t width, std::int32_t height, const RealClock& clock,
                          V4l2Camera& camera);

/// Asks the device of `settings` for its present picture size.
Status find_video_size(const char* settings, VideoDevice& device, std::int32_t& width, std::int32_t& height);

}  // namespace ilp
