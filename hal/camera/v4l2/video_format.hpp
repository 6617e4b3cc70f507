// Agreeing with a video device on what it delivers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "hal/camera/v4l2/v4l2_options.hpp"
#include "hal/camera/v4l2/video_device.hpp"

namespace ilp {

/// News that is no reason to stop, told one by one; what does not fit is counted by the caller's `full()`.
using CameraNews = FixedVector<Status, limits::max_camera_news>;

struct VideoFormat {
  PixelFormat pixel{};
  std::int32_t width = 0, height = 0;
  std::size_t stride = 0;       ///< bytes from row to row
  std::size_t image_bytes = 0;  ///< that a frame has at least
  TimeNs period_ns = 0;         ///< as the driver states it; 0: it does not
};

/// The device is a camera that streams single planes, or `camera_incapable`.
Status check_capabilities(VideoDevice& device);
/// Sets input, format, size and rate and believes only what comes back. `camera_size` with both sizes when the device
/// gives another one, `unsupported_format` (a = four-character code that it offers), `camera_fault` for a failed call
/// and for a row or image length that cannot be. Another rate is news.
Status negotiate(VideoDevice& device, const V4l2Options& options, std::int32_t width, std::int32_t height,
                 VideoFormat& format, CameraNews& news);
/// Exposure and gain, within the driver's own ranges; a limited or missing control is news.
void set_controls(VideoDevice& device, const V4l2Options& options, CameraNews& news);

/// Width and height of a picture in one number that can be read: width * 100000 + height.
[[nodiscard]] constexpr std::int64_t readable_size(std::int64_t width, std::int64_t height) {
  return width * 100'000 + height;
}

}  // namespace ilp
