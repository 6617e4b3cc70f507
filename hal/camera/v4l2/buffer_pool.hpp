// Exchanges frame buffers with the driver, and checks everything that the driver reports about them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "hal/camera/v4l2/video_device.hpp"

namespace ilp {

/// A frame as the driver reported it.
struct VideoBuffer {
  std::uint32_t index = 0;                 ///< index of its buffer in the pool
  std::uint32_t sequence = 0;              ///< the driver's frame counter
  std::uint32_t flags = 0;                 ///< V4L2_BUF_FLAG_...
  std::size_t bytes_used = 0;              ///< size of the frame in the buffer
  std::int64_t stamp_s = 0, stamp_us = 0;  ///< the driver's time stamp: seconds, and microseconds of the second
};

/// Returns `camera_fault` (first value: errno, second: number of the request in videodev2.h).
[[nodiscard]] Status driver_fault(int error, unsigned long request);

class BufferPool {
 public:
  explicit BufferPool(VideoDevice& device) : device_(device) {}

  /// Maps up to limits::max_camera_buffers buffers of the driver. Returns `camera_buffers` if the driver gives too few
  /// or too many, `camera_layout` if one has less than `image_bytes`, `camera_fault` if a request fails.
  Status allocate(std::size_t image_bytes);
  /// Gives all buffers to the driver and starts the stream. Returns `camera_fault` if a request fails.
  Status start();
  /// Takes the oldest frame that the driver has finished; give_back() returns its buffer. Returns `not_ready` if there
  /// is none, `camera_fault` if a request fails, and `camera_protocol` if the driver reports a buffer that it does not
  /// hold. After `camera_protocol` the stream must be started again, because the driver's reports cannot be trusted.
  Status take(VideoBuffer& buffer);
  /// Returns a buffer to the driver. If the driver refuses, the next calls of take() try again.
  void give_back(std::uint32_t index);
  /// Stops the stream and unmaps everything, so that the driver can change its format. Allowed in any state.
  void release();

  /// Memory of the buffer with this index.
  [[nodiscard]] std::span<const std::uint8_t> bytes(std::uint32_t index) const { return slots_[index].bytes; }
  /// Number of buffers.
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  enum class Holder : std::uint8_t { nobody, driver, flight };
  struct Slot {
    std::span<const std::uint8_t> bytes;
    Holder holder = Holder::nobody;
  };
  Status map(std::uint32_t index, std::size_t image_bytes);
  /// Gives a buffer to the driver; returns an errno.
  [[nodiscard]] int queue(std::uint32_t index);
  /// Gives the driver all buffers that it has refused earlier.
  Status queue_what_nobody_has();

  VideoDevice& device_;
  std::array<Slot, limits::max_camera_buffers> slots_{};
  std::size_t count_ = 0;
  int refusals_ = 0;  ///< consecutive buffers that the driver has refused
  bool requested_ = false;
  bool streaming_ = false;
};

}  // namespace ilp
