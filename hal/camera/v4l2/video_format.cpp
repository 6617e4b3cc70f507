#include "hal/camera/v4l2/video_format.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <iterator>

#include "hal/camera/v4l2/buffer_pool.hpp"

namespace ilp {
namespace {

constexpr TimeNs longest_period_ns = 3600 * ns_per_s;
constexpr std::size_t least_jpeg_bytes = 4;  // its beginning and its end
constexpr std::size_t most_listed_formats = 64;
constexpr std::int64_t us_per_exposure_step = 100;  // of V4L2_CID_EXPOSURE_ABSOLUTE

void report(CameraUpdates& updates, const Status& status) {
  // The first reports matter most; there are fewer kinds of reports than places.
  static_cast<void>(updates.push_back(status));
}

Status set_input(VideoDevice& device, std::int64_t wanted) {
  if (wanted == V4l2Options::as_it_is) return {};
  int input = static_cast<int>(wanted);
  const int error = device.control(VIDIOC_S_INPUT, &input);
  if (error != 0) return driver_fault(error, VIDIOC_S_INPUT);
  return {};
}

using FormatList = FixedVector<std::uint32_t, most_listed_formats>;

/// The formats that the device lists; none if it does not list them.
FormatList listed_formats(VideoDevice& device) {
  FormatList formats;
  for (std::uint32_t i = 0; i < most_listed_formats; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = frame_buffers;
    if (device.control(VIDIOC_ENUM_FMT, &description) != 0) break;
    if (!formats.push_back(description.pixelformat)) break;
  }
  return formats;
}

/// Whether the format is wished for, and not known to be absent.
bool eligible(const PixelFormat& format, const V4l2Options& options, const FormatList& listed) {
  if (options.format != nullptr) return options.format->fourcc == format.fourcc;
  return listed.empty() || std::find(listed.begin(), listed.end(), format.fourcc) != listed.end();
}

/// Requests a format; `unsupported_format` when the device chose another one.
Status ask_for(VideoDevice& device, const PixelFormat& wish, std::int32_t width, std::int32_t height,
               v4l2_pix_format& answer) {
  v4l2_format asked{};
  asked.type = frame_buffers;
  asked.fmt.pix.width = static_cast<std::uint32_t>(width);
  asked.fmt.pix.height = static_cast<std::uint32_t>(height);
  asked.fmt.pix.pixelformat = wish.fourcc;
  asked.fmt.pix.field = V4L2_FIELD_NONE;
  const int error = device.control(VIDIOC_S_FMT, &asked);
  if (error == EINVAL) return {StatusCode::unsupported_format, wish.fourcc};
  if (error != 0) return driver_fault(error, VIDIOC_S_FMT);
  answer = asked.fmt.pix;
  // Alternating half pictures are of no use from a moving camera.
  const bool whole = answer.field == V4L2_FIELD_NONE || answer.field == V4L2_FIELD_ANY;
  if (answer.pixelformat != wish.fourcc || !whole) return {StatusCode::unsupported_format, answer.pixelformat};
  return {};
}

/// The layout that the device states, or `camera_layout` when no picture of this size has it.
Status check_layout(const v4l2_pix_format& answer, VideoFormat& format) {
  if (format.pixel.packing == Packing::jpeg) {
    format.stride = 0;
    format.image_bytes = least_jpeg_bytes;
    if (answer.sizeimage >= format.image_bytes) return {};
    return {StatusCode::camera_layout, answer.sizeimage, static_cast<std::int64_t>(format.image_bytes)};
  }
  const std::size_t row = row_bytes(format.pixel, format.width);
  // Some drivers report 0 for rows without padding.
  format.stride = answer.bytesperline == 0 ? row : answer.bytesperline;
  if (format.stride < row || format.stride > limits::max_camera_row_bytes) {
    return {StatusCode::camera_layout, static_cast<std::int64_t>(format.stride), static_cast<std::int64_t>(row)};
  }
  format.image_bytes = format.stride * (static_cast<std::size_t>(format.height) - 1) + row;
  if (answer.sizeimage >= format.image_bytes) return {};
  return {StatusCode::camera_layout, answer.sizeimage, static_cast<std::int64_t>(format.image_bytes)};
}

TimeNs period_of(const v4l2_fract& time_per_frame) {
  if (time_per_frame.numerator == 0 || time_per_frame.denominator == 0) return 0;
  const TimeNs period = static_cast<TimeNs>(time_per_frame.numerator) * ns_per_s / time_per_frame.denominator;
  return period <= longest_period_ns ? period : 0;
}

/// Devices without a rate of their own (a video input, say) are accepted.
void set_rate(VideoDevice& device, std::int64_t rate_mhz, VideoFormat& format, CameraUpdates& updates) {
  v4l2_streamparm parameters{};
  parameters.type = frame_buffers;
  if (device.control(VIDIOC_G_PARM, &parameters) != 0) parameters.parm.capture = {};
  const bool can = (parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  if (rate_mhz != V4l2Options::as_it_is && can) {
    parameters.type = frame_buffers;
    parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(rate_mhz)};
    if (device.control(VIDIOC_S_PARM, &parameters) != 0) parameters.parm.capture = {};
  }
  format.period_ns = period_of(parameters.parm.capture.timeperframe);
  if (rate_mhz == V4l2Options::as_it_is) return;
  const std::int64_t given_mhz = format.period_ns > 0 ? 1000 * ns_per_s / format.period_ns : 0;
  const std::int64_t off = given_mhz > rate_mhz ? given_mhz - rate_mhz : rate_mhz - given_mhz;
  if (off > rate_mhz / 100) report(updates, {StatusCode::camera_rate, rate_mhz, given_mhz});
}

bool query(VideoDevice& device, std::uint32_t id, v4l2_queryctrl& control) {
  control = {};
  control.id = id;
  return device.control(VIDIOC_QUERYCTRL, &control) == 0 && (control.flags & V4L2_CTRL_FLAG_DISABLED) == 0 &&
         control.minimum <= control.maximum;
}

bool write_control(VideoDevice& device, std::uint32_t id, std::int32_t value) {
  v4l2_control control{id, value};
  return device.control(VIDIOC_S_CTRL, &control) == 0;
}

/// Switches off a control that the camera would otherwise change by itself.
void switch_off(VideoDevice& device, std::uint32_t id, std::int32_t off) {
  v4l2_queryctrl control;
  if (query(device, id, control)) static_cast<void>(write_control(device, id, off));
}

void set_control(VideoDevice& device, std::uint32_t id, std::int64_t wanted, CameraUpdates& updates) {
  v4l2_queryctrl control;
  if (!query(device, id, control)) {
    report(updates, {StatusCode::camera_control_missing, id});
    return;
  }
  const std::int64_t step = std::max(control.step, 1);
  std::int64_t value = std::clamp<std::int64_t>(wanted, control.minimum, control.maximum);
  value = control.minimum + (value - control.minimum) / step * step;
  v4l2_control now{id, 0};
  const bool written = write_control(device, id, static_cast<std::int32_t>(value));
  if (!written || device.control(VIDIOC_G_CTRL, &now) != 0) {
    report(updates, {StatusCode::camera_control_missing, id});
  } else if (now.value != wanted) {
    report(updates, {StatusCode::camera_control_limited, id, now.value});
  }
}

}  // namespace

Status check_capabilities(VideoDevice& device, DeviceName& name) {
  v4l2_capability capability{};
  const int error = device.control(VIDIOC_QUERYCAP, &capability);
  if (error != 0) return driver_fault(error, VIDIOC_QUERYCAP);
  std::copy(std::begin(capability.driver), std::end(capability.driver), name.driver.begin());
  std::copy(std::begin(capability.card), std::end(capability.card), name.model.begin());
  const bool of_node = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  const std::uint32_t can = of_node ? capability.device_caps : capability.capabilities;
  constexpr std::uint32_t needed = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if ((can & needed) == needed) return {};
  return {StatusCode::camera_incapable, can};
}

Status present_size(VideoDevice& device, const V4l2Options& options, std::int32_t& width, std::int32_t& height) {
  const int error = device.open(options.device);
  if (error != 0) return {StatusCode::camera_absent, error};
  v4l2_format present{};
  present.type = frame_buffers;
  Status status = set_input(device, options.input);
  if (status.ok()) {
    const int refused = device.control(VIDIOC_G_FMT, &present);
    if (refused != 0) status = driver_fault(refused, VIDIOC_G_FMT);
  }
  device.close();
  width = static_cast<std::int32_t>(present.fmt.pix.width);
  height = static_cast<std::int32_t>(present.fmt.pix.height);
  return status;
}

namespace {

/// Sets the first eligible format that the device has in this size. Another size is the answer only where no format
/// has the right one.
Status choose_format(VideoDevice& device, const V4l2Options& options, VideoFormat& format, v4l2_pix_format& answer) {
  const FormatList listed = listed_formats(device);
  Status refusal{StatusCode::unsupported_format, listed.empty() ? 0 : listed[0]};
  for (const PixelFormat& wish : pixel_formats()) {
    if (!eligible(wish, options, listed)) continue;
    format.pixel = wish;
    Status status = ask_for(device, wish, format.width, format.height, answer);
    const bool same_size = answer.width == static_cast<std::uint32_t>(format.width) &&
                           answer.height == static_cast<std::uint32_t>(format.height);
    if (status.ok() && same_size) return {};
    if (status.ok()) {
      status = {StatusCode::camera_size, readable_size(format.width, format.height),
                readable_size(answer.width, answer.height)};
    } else if (!status.is(StatusCode::unsupported_format)) {
      return status;
    }
    if (!refusal.is(StatusCode::camera_size)) refusal = status;
  }
  return refusal;
}

}  // namespace

Status negotiate(VideoDevice& device, const V4l2Options& options, std::int32_t width, std::int32_t height,
                 VideoFormat& format, CameraUpdates& updates) {
  ILP_TRY(set_input(device, options.input));
  v4l2_pix_format answer{};
  format.width = width;
  format.height = height;
  ILP_TRY(choose_format(device, options, format, answer));
  ILP_TRY(check_layout(answer, format));
  set_rate(device, options.rate_mhz, format, updates);
  return {};
}

void set_controls(VideoDevice& device, const V4l2Options& options, CameraUpdates& updates) {
  if (options.exposure_us != V4l2Options::as_it_is) {
    switch_off(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
    set_control(device, V4L2_CID_EXPOSURE_ABSOLUTE, options.exposure_us / us_per_exposure_step, updates);
  }
  if (options.gain != V4l2Options::as_it_is) {
    switch_off(device, V4L2_CID_AUTOGAIN, 0);
    set_control(device, V4L2_CID_GAIN, options.gain, updates);
  }
}

Status find_exposure_range(VideoDevice& device, std::int64_t gain_unit, ExposureRange& range) {
  v4l2_queryctrl exposure;
  switch_off(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
  // A driver may allow the manual value only now.
  if (!query(device, V4L2_CID_EXPOSURE_ABSOLUTE, exposure) || (exposure.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0 ||
      exposure.maximum < 1) {
    return {StatusCode::camera_control_missing, V4L2_CID_EXPOSURE_ABSOLUTE};
  }
  range = {};
  range.step_us = us_per_exposure_step * std::max(exposure.step, 1);
  range.least_us = us_per_exposure_step * std::max(exposure.minimum, 1);
  range.most_us = us_per_exposure_step * exposure.maximum;
  switch_off(device, V4L2_CID_AUTOGAIN, 0);
  v4l2_queryctrl gain;
  if (query(device, V4L2_CID_GAIN, gain) && (gain.flags & V4L2_CTRL_FLAG_READ_ONLY) == 0) {
    range.most_gain_milli += 1000 * (static_cast<std::int64_t>(gain.maximum) - gain.minimum) / gain_unit;
  }
  return {};
}

namespace {

Status write_and_read(VideoDevice& device, std::uint32_t id, std::int64_t wanted, std::int32_t& value) {
  v4l2_control now{id, 0};
  const bool written = write_control(device, id, static_cast<std::int32_t>(wanted));
  if (!written || device.control(VIDIOC_G_CTRL, &now) != 0) return {StatusCode::camera_control_missing, id};
  value = now.value;
  return {};
}

}  // namespace

Status write_exposure(VideoDevice& device, std::int64_t gain_unit, ExposureSetting& setting) {
  std::int32_t value = 0;
  ILP_TRY(write_and_read(device, V4L2_CID_EXPOSURE_ABSOLUTE, setting.exposure_us / us_per_exposure_step, value));
  setting.exposure_us = us_per_exposure_step * std::max(value, 1);
  v4l2_queryctrl gain;
  const bool has_gain = query(device, V4L2_CID_GAIN, gain) && (gain.flags & V4L2_CTRL_FLAG_READ_ONLY) == 0;
  if (!has_gain) {
    setting.gain_milli = 1000;
    return {};
  }
  const std::int64_t step = std::max(gain.step, 1);
  const std::int64_t wanted = (setting.gain_milli - 1000) * gain_unit / 1000 / step * step + gain.minimum;
  ILP_TRY(write_and_read(device, V4L2_CID_GAIN, std::clamp<std::int64_t>(wanted, gain.minimum, gain.maximum), value));
  setting.gain_milli = 1000 + 1000 * (static_cast<std::int64_t>(value) - gain.minimum) / gain_unit;
  return {};
}

}  // namespace ilp
