// Negotiates the delivered format with a video device.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "hal/camera/camera.hpp"
#include "hal/camera/v4l2/v4l2_options.hpp"
#include "hal/camera/v4l2/video_device.hpp"

namespace ilp {

/// Reports that are no reason to stop, sent one by one. The caller's `full()` counts those that do not fit.
using CameraUpdates = FixedVector<Status, limits::max_camera_updates>;

struct VideoFormat {
  PixelFormat pixel{};
  std::int32_t width = 0, height = 0;
  std::size_t stride = 0;       ///< bytes from row to row; 0 for JPEG
  std::size_t image_bytes = 0;  ///< least size of a frame
  TimeNs period_ns = 0;         ///< as the driver reports it; 0: not reported
};

/// Asks the device named in `options` for the picture size to which it is set at present. `camera_absent` (a = errno)
/// if it cannot be opened, `camera_fault` for a failed call. The device is closed afterwards.
Status present_size(VideoDevice& device, const V4l2Options& options, std::int32_t& width, std::int32_t& height);
/// What a device calls itself: its driver and its model.
struct DeviceName {
  std::array<std::uint8_t, 16> driver{};
  std::array<std::uint8_t, 32> model{};
  bool operator==(const DeviceName&) const = default;
};
/// Returns ok for a camera that streams single planes, else `camera_incapable`.
Status check_capabilities(VideoDevice& device, DeviceName& name);
/// Sets input, format, size and rate and trusts only the values read back. The format is that of `options`, or the
/// first of pixel_formats() that the device has in this size. `camera_size` with both sizes when the device gives
/// another one, `unsupported_format` (a = four-character code that it offers), `camera_fault` for a failed call,
/// `camera_layout` for an impossible row or image length. Another rate is reported in `updates`.
Status negotiate(VideoDevice& device, const V4l2Options& options, std::int32_t width, std::int32_t height,
                 VideoFormat& format, CameraUpdates& updates);
/// Sets exposure and gain within the driver's ranges. A limited or missing control is reported in `updates`.
void set_controls(VideoDevice& device, const V4l2Options& options, CameraUpdates& updates);

/// Switches automatic exposure and gain off and asks for the ranges and the present values. A gain of 1 is the driver's
/// least value, and `gain_unit` of its steps add another 1. `camera_control_missing` (a = control) without a settable
/// exposure; a missing gain stays at 1.
Status find_exposure_range(VideoDevice& device, std::int64_t gain_unit, ExposureRange& range);
/// Sets both, and reads back what the driver has made of it.
Status write_exposure(VideoDevice& device, std::int64_t gain_unit, ExposureSetting& setting);

/// Width and height of a picture in one readable number: width * 100000 + height.
[[nodiscard]] constexpr std::int64_t readable_size(std::int64_t width, std::int64_t height) {
  return width * 100'000 + height;
}

}  // namespace ilp
