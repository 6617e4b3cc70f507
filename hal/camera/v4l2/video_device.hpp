// What the V4L2 camera asks of the operating system: the few system calls on one video device.
#pragma once

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// Of the device: pictures in single planes.
inline constexpr std::uint32_t frame_buffers = V4L2_BUF_TYPE_VIDEO_CAPTURE;

/// Results are 0 or an errno. No call blocks but `wait`.
class VideoDevice {
 public:
  VideoDevice() = default;
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;

  [[nodiscard]] virtual int open(const char* path) = 0;
  /// Of a device that is not open: nothing happens.
  virtual void close() = 0;
  /// A VIDIOC_ request with its argument.
  [[nodiscard]] virtual int control(unsigned long request, void* argument) = 0;
  /// A buffer of the driver, to be read.
  [[nodiscard]] virtual int map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) = 0;
  virtual void unmap(std::span<const std::uint8_t> bytes) = 0;
  /// Until a frame can be taken, an error waits, or the time has passed (`readable` is false then); 0 only asks.
  [[nodiscard]] virtual int wait(int timeout_ms, bool& readable) = 0;

 protected:
  ~VideoDevice() = default;
};

}  // namespace ilp
