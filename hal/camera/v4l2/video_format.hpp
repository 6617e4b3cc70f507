// Agrees with a video device on format, size and rate of its pictures, and sets exposure and gain.
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

/// Reports that do not stop the camera. Those that do not fit are lost.
using CameraUpdates = FixedVector<Status, limits::max_camera_updates>;

struct VideoFormat {
  PixelFormat pixel{};
  std::int32_t width = 0, height = 0;  ///< px
  std::size_t stride = 0;              ///< bytes from the beginning of a row to that of the next; 0 for JPEG
  std::size_t image_bytes = 0;         ///< least size of a frame
  TimeNs period_ns = 0;                ///< frame period that the driver reports; 0: not reported
};

/// Opens the device named in `options`, reads the size to which its pictures are set at present, px, and closes it.
/// Returns `camera_absent` (first value: errno) if the device cannot be opened, `camera_fault` if a request fails.
Status present_size(VideoDevice& device, const V4l2Options& options, std::int32_t& width, std::int32_t& height);
/// The names of its driver and model that a device reports.
struct DeviceName {
  std::array<std::uint8_t, 16> driver{};
  std::array<std::uint8_t, 32> model{};
  bool operator==(const DeviceName&) const = default;
};
/// Reads the device's name. Returns `camera_incapable` (first value: V4L2 capabilities) if the device is no camera that
/// streams single planes, `camera_fault` if the request fails.
Status check_capabilities(VideoDevice& device, DeviceName& name);
/// Sets input, format, size and rate, and fills `format` with the values that the device reports afterwards. The pixel
/// format is that of `options`, or else the first of pixel_formats() that the device has in this size. Returns
/// `camera_size` (first value: readable_size() wanted, second: given) if no format has this size, `unsupported_format`
/// (first value: a four-character code that the device offers) if none is supported, `camera_layout` if the stated
/// length of a row or picture is impossible, `camera_fault` if a request fails. A rate that differs by more than 1 % is
/// reported in `updates`.
Status negotiate(VideoDevice& device, const V4l2Options& options, std::int32_t width, std::int32_t height,
                 VideoFormat& format, CameraUpdates& updates);
/// Sets the exposure and gain of `options`, clamped to the driver's ranges. A clamped or missing control is reported in
/// `updates`.
void set_controls(VideoDevice& device, const V4l2Options& options, CameraUpdates& updates);

/// Switches automatic exposure and gain off and reads the ranges. The driver's least gain value is a gain of 1, and
/// each `gain_unit` of its steps add 1. Returns `camera_control_missing` (first value: control) if the exposure cannot
/// be set. If the gain cannot be set, its range is 1 to 1.
Status find_exposure_range(VideoDevice& device, std::int64_t gain_unit, ExposureRange& range);
/// Sets exposure and gain, and replaces `setting` by the values that the driver reports afterwards. Returns
/// `camera_control_missing` (first value: control) if a control cannot be set.
Status write_exposure(VideoDevice& device, std::int64_t gain_unit, ExposureSetting& setting);

/// Combines width and height of a picture, px, into one readable number: width * 100000 + height.
[[nodiscard]] constexpr std::int64_t readable_size(std::int64_t width, std::int64_t height) {
  return width * 100'000 + height;
}

}  // namespace ilp
