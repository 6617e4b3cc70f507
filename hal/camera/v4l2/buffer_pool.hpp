// The driver's frame buffers and their owners, with a check of everything that the driver reports.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "hal/camera/v4l2/video_device.hpp"

namespace ilp {

/// A frame as the driver returned it.
struct VideoBuffer {
  std::uint32_t index = 0;
  std::uint32_t sequence = 0;
  std::uint32_t flags = 0;  ///< V4L2_BUF_FLAG_...
  std::size_t bytes_used = 0;
  std::int64_t stamp_s = 0, stamp_us = 0;
};

/// `camera_fault` with errno and the number of the request (videodev2.h).
[[nodiscard]] Status driver_fault(int error, unsigned long request);

class BufferPool {
 public:
  explicit BufferPool(VideoDevice& device) : device_(device) {}

  /// Maps up to limits::max_camera_buffers buffers that each hold `image_bytes`. `camera_buffers` when the driver gives
  /// too few, too many or too small ones.
  Status allocate(std::size_t image_bytes);
  /// Gives all buffers to the driver and starts the stream.
  Status start();
  /// The oldest frame that the driver has finished, or `not_ready`. `camera_protocol` when it returns a buffer that it
  /// does not have: its reports are then not trusted until the stream is started again.
  Status take(VideoBuffer& buffer);
  /// Returns a buffer to the driver; if the driver refuses, one of the next calls tries again.
  void give_back(std::uint32_t index);
  /// Stops the stream and unmaps everything, so that the driver can change its format. Allowed in any state.
  void release();

  [[nodiscard]] std::span<const std::uint8_t> bytes(std::uint32_t index) const { return slots_[index].bytes; }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  enum class Holder : std::uint8_t { nobody, driver, flight };
  struct Slot {
    std::span<const std::uint8_t> bytes;
    Holder holder = Holder::nobody;
  };
  Status map(std::uint32_t index, std::size_t image_bytes);
  [[nodiscard]] int queue(std::uint32_t index);
  Status queue_what_nobody_has();

  VideoDevice& device_;
  std::array<Slot, limits::max_camera_buffers> slots_{};
  std::size_t count_ = 0;
  int refusals_ = 0;  ///< refused buffers in a row
  bool requested_ = false;
  bool streaming_ = false;
};

}  // namespace ilp
