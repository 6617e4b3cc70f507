// The few system calls of the V4L2 camera on one video device.
#pragma once

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// Type of the device's buffers: pictures in single planes.
inline constexpr std::uint32_t frame_buffers = V4L2_BUF_TYPE_VIDEO_CAPTURE;

/// Results are 0 or an errno. Only `wait` blocks.
class VideoDevice {
 public:
  VideoDevice() = default;
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;

  [[nodiscard]] virtual int open(const char* path) = 0;
  /// Does nothing if the device is not open.
  virtual void close() = 0;
  /// A VIDIOC_ request with its argument.
  [[nodiscard]] virtual int control(unsigned long request, void* argument) = 0;
  /// Maps a buffer of the driver for reading.
  [[nodiscard]] virtual int map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) = 0;
  virtual void unmap(std::span<const std::uint8_t> bytes) = 0;
  /// Waits until a frame can be taken, an error is pending, or the time has passed (`readable` is false then). 0 does
  /// not wait.
  [[nodiscard]] virtual int wait(int timeout_ms, bool& readable) = 0;

 protected:
  ~VideoDevice() = default;
};

}  // namespace ilp
