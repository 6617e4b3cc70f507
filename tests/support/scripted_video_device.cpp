#include "tests/support/scripted_video_device.hpp"

#include <algorithm>
#include <cerrno>

#include "fsw/base/text.hpp"

namespace ilp::test {
namespace {

std::uint32_t bytes_per_pixel(std::uint32_t fourcc) {
  return fourcc == V4L2_PIX_FMT_GREY || fourcc == V4L2_PIX_FMT_NV12 || fourcc == V4L2_PIX_FMT_SRGGB8 ? 1 : 2;
}

/// As drivers state them; rows of compressed pictures have no length.
void state_layout(v4l2_pix_format& pix, std::uint32_t padding) {
  const bool compressed = pix.pixelformat == V4L2_PIX_FMT_MJPEG;
  pix.bytesperline = pix.width * bytes_per_pixel(pix.pixelformat) + padding;
  if (pix.pixelformat == V4L2_PIX_FMT_SRGGB10P) pix.bytesperline = pix.width * 5 / 4 + padding;
  pix.sizeimage = pix.bytesperline * pix.height;
  if (pix.pixelformat == V4L2_PIX_FMT_NV12) pix.sizeimage += pix.sizeimage / 2;
  if (compressed) pix.bytesperline = 0;
}

}  // namespace

int ScriptedVideoDevice::open(const char* path) {
  static_cast<void>(path);
  ++open_attempts;
  if (!present) return ENOENT;
  if (open_) misuse.emplace_back("opened twice");
  open_ = true;
  ++times_opened;
  return 0;
}

void ScriptedVideoDevice::close() {
  if (mapped > 0) misuse.emplace_back("closed with buffers mapped");
  open_ = false;
  stop();
  slots_.clear();
}

void ScriptedVideoDevice::stop() {
  streaming_ = false;
  queue_.clear();
  finished_.clear();
  for (Slot& slot : slots_) slot.queued = false;
}

void ScriptedVideoDevice::draw(std::vector<std::uint8_t>& bytes, std::int64_t number) const {
  if (whole_picture) {
    whole_picture(number, format_, bytes);
    return;
  }
  const std::uint32_t pixel_bytes = bytes_per_pixel(format_.pixelformat);
  const auto content = [&](std::int32_t x, std::int32_t y) {
    if (picture) return picture(number, x, y);
    return static_cast<std::uint8_t>(number * 37 + 3 * x + y);
  };
  for (std::uint32_t y = 0; y < format_.height; ++y) {
    for (std::uint32_t x = 0; x < format_.width; ++x) {
      const std::size_t at = std::size_t{y} * format_.bytesperline + std::size_t{x} * pixel_bytes;
      bytes.at(at) = content(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
    }
  }
}

void ScriptedVideoDevice::finish_frame(TimeNs exposed_ns) {
  ++number_;
  const std::uint32_t sequence = sequence_++;
  if (queue_.empty()) {
    ++frames_without_buffer;
    return;
  }
  const std::uint32_t index = queue_.front();
  queue_.pop_front();
  v4l2_buffer buffer{};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.sequence = sequence;
  buffer.bytesused = format_.sizeimage;
  buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  const TimeNs stamp = exposed_ns - mission_minus_monotonic;
  buffer.timestamp.tv_sec = stamp / ns_per_s;
  buffer.timestamp.tv_usec = stamp % ns_per_s / ns_per_us;
  draw(slots_[index].bytes, number_);
  Frame frame{number_, exposed_ns, buffer, slots_[index].bytes};
  if (spoil) spoil(frame);
  exposures.push_back(exposed_ns);
  finished_.push_back(frame.buffer);
}

void ScriptedVideoDevice::expose_until(TimeNs now) {
  if (!streaming_ || !present) return;
  while (next_exposure_ns_ + transfer_ns <= now) {
    if (!silent) finish_frame(next_exposure_ns_);
    next_exposure_ns_ += period_ns;
  }
}

int ScriptedVideoDevice::set_format(v4l2_format& format) {
  if (!slots_.empty()) return EBUSY;
  v4l2_pix_format& pix = format.fmt.pix;
  if (std::find(formats.begin(), formats.end(), pix.pixelformat) == formats.end()) pix.pixelformat = formats.front();
  const auto own = sizes.find(pix.pixelformat);
  if (own != sizes.end()) {
    pix.width = own->second.first;
    pix.height = own->second.second;
  }
  if (width != 0) pix.width = static_cast<std::uint32_t>(width);
  if (height != 0) pix.height = static_cast<std::uint32_t>(height);
  pix.field = V4L2_FIELD_NONE;
  state_layout(pix, stride_padding);
  format_ = pix;
  pix.bytesperline += stated_stride_change;
  pix.sizeimage += stated_size_change;
  return 0;
}

int ScriptedVideoDevice::request_buffers(v4l2_requestbuffers& request) {
  if (mapped > 0) return EBUSY;
  if (request.count > 0) request.count = std::max(std::min(request.count, most_buffers), least_buffers);
  stop();
  slots_.assign(request.count, {});
  for (Slot& slot : slots_) slot.bytes.resize(format_.sizeimage);
  return 0;
}

int ScriptedVideoDevice::query_buffer(v4l2_buffer& buffer) const {
  if (buffer.index >= slots_.size()) return EINVAL;
  buffer.length = format_.sizeimage + length_change;
  buffer.m.offset = buffer.index << 12U;
  return 0;
}

int ScriptedVideoDevice::queue_buffer(const v4l2_buffer& buffer) {
  if (buffer.index >= slots_.size() || slots_[buffer.index].queued) {
    misuse.emplace_back("queued a buffer that is none, or twice");
    return EINVAL;
  }
  slots_[buffer.index].queued = true;
  queue_.push_back(buffer.index);
  return 0;
}

int ScriptedVideoDevice::take_buffer(v4l2_buffer& buffer) {
  if (finished_.empty()) return EAGAIN;
  const v4l2_buffer& frame = finished_.front();
  if (frame.index < slots_.size()) slots_[frame.index].queued = false;
  buffer = frame;
  finished_.pop_front();
  ++frames_taken;
  return 0;
}

int ScriptedVideoDevice::query_control(v4l2_queryctrl& control) const {
  const auto found = controls.find(control.id);
  if (found == controls.end()) return EINVAL;
  control.minimum = found->second.minimum;
  control.maximum = found->second.maximum;
  control.step = found->second.step;
  return 0;
}

int ScriptedVideoDevice::answer(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      copy_text(reinterpret_cast<char(&)[sizeof(capability.card)]>(capability.card), model.c_str());
      capability.capabilities = V4L2_CAP_DEVICE_CAPS | capabilities;
      capability.device_caps = capabilities;
      return 0;
    }
    case VIDIOC_S_FMT:
      return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_ENUM_FMT: {
      auto& description = *static_cast<v4l2_fmtdesc*>(argument);
      if (!lists_formats || description.index >= formats.size()) return EINVAL;
      description.pixelformat = formats[description.index];
      return 0;
    }
    case VIDIOC_G_FMT: {
      v4l2_pix_format& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
      pix.width = static_cast<std::uint32_t>(width);
      pix.height = static_cast<std::uint32_t>(height);
      return 0;
    }
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      if (!states_rate) return ENOTTY;
      auto& parameters = *static_cast<v4l2_streamparm*>(argument);
      parameters.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
      parameters.parm.capture.timeperframe = {static_cast<std::uint32_t>(period_ns / ns_per_us), 1'000'000};
      return 0;
    }
    case VIDIOC_QUERYCTRL:
      return query_control(*static_cast<v4l2_queryctrl*>(argument));
    case VIDIOC_S_CTRL: {
      const auto& control = *static_cast<v4l2_control*>(argument);
      if (controls.count(control.id) == 0) return EINVAL;
      Control& known = controls[control.id];
      // As the kernel does it.
      known.value = std::clamp(control.value, known.minimum, known.maximum);
      return 0;
    }
    case VIDIOC_G_CTRL: {
      auto& control = *static_cast<v4l2_control*>(argument);
      if (controls.count(control.id) == 0) return EINVAL;
      control.value = controls[control.id].value;
      return 0;
    }
    case VIDIOC_REQBUFS:
      return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return query_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return take_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON: {
      streaming_ = true;
      sequence_ = 0;
      const TimeNs late = std::max<TimeNs>(clock_.now() - first_exposure_ns, 0);
      next_exposure_ns_ = first_exposure_ns + (late + period_ns - 1) / period_ns * period_ns;
      return 0;
    }
    case VIDIOC_STREAMOFF:
      stop();
      return 0;
    default:
      return ENOTTY;
  }
}

int ScriptedVideoDevice::control(unsigned long request, void* argument) {
  ++requests[request];
  if (!present) return ENODEV;
  if (!open_) {
    misuse.emplace_back("asked while closed");
    return EBADF;
  }
  expose_until(clock_.now());
  std::deque<int>& planned = failures[request];
  if (!planned.empty()) {
    const int error = planned.front();
    planned.pop_front();
    if (error != 0) return error;
  }
  return answer(request, argument);
}

int ScriptedVideoDevice::map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) {
  const auto index = static_cast<std::size_t>(offset >> 12U);
  if (index >= slots_.size()) return EINVAL;
  slots_[index].bytes.resize(length);
  slots_[index].mapped = true;
  ++mapped;
  bytes = slots_[index].bytes;
  return 0;
}

void ScriptedVideoDevice::unmap(std::span<const std::uint8_t> bytes) {
  for (Slot& slot : slots_) {
    if (slot.bytes.data() != bytes.data() || !slot.mapped) continue;
    slot.mapped = false;
    --mapped;
    return;
  }
  misuse.emplace_back("unmapped what was not mapped");
}

int ScriptedVideoDevice::wait(int timeout_ms, bool& readable) {
  longest_wait_ms = std::max(longest_wait_ms, timeout_ms);
  expose_until(clock_.now());
  const TimeNs end = clock_.now() + timeout_ms * ns_per_ms;
  while (present && streaming_ && finished_.empty() && clock_.now() < end) {
    clock_.sleep_until(std::min(end, next_exposure_ns_ + transfer_ns));
    expose_until(clock_.now());
  }
  const bool erroneous = !failures[VIDIOC_DQBUF].empty() && failures[VIDIOC_DQBUF].front() != 0;
  readable = !present || !streaming_ || !finished_.empty() || erroneous;
  return 0;
}

}  // namespace ilp::test
