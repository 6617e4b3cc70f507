// Interface of the system calls that the V4L2 camera makes on a video device. Tests replace it.
#pragma once

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// V4L2 type of the device's buffers: each picture lies in one buffer.
inline constexpr std::uint32_t frame_buffers = V4L2_BUF_TYPE_VIDEO_CAPTURE;

/// The functions return 0 or an errno. Only wait() blocks.
class VideoDevice {
 public:
  VideoDevice() = default;
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;

  [[nodiscard]] virtual int open(const char* path) = 0;
  /// Does nothing if the device is not open.
  virtual void close() = 0;
  /// Makes a VIDIOC_ request with its argument.
  [[nodiscard]] virtual int control(unsigned long request, void* argument) = 0;
  /// Maps a buffer of the driver for reading.
  [[nodiscard]] virtual int map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) = 0;
  virtual void unmap(std::span<const std::uint8_t> bytes) = 0;
  /// Waits until a frame can be taken or an error is pending, at most `timeout_ms`; 0 does not wait. `readable` is
  /// false if the time has passed.
  [[nodiscard]] virtual int wait(int timeout_ms, bool& readable) = 0;

 protected:
  ~VideoDevice() = default;
};

}  // namespace ilp
