// A simulated video device for tests: a camera and its driver in virtual time, which behave correctly unless a test
// sets a fault.
#pragma once

#include <linux/videodev2.h>

#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hal/camera/v4l2/video_device.hpp"
#include "hal/clock/virtual_clock.hpp"

namespace ilp::test {

class ScriptedVideoDevice final : public VideoDevice {
 public:
  /// Mission time minus the device's monotonic time.
  static constexpr TimeNs mission_minus_monotonic = 7 * ns_per_s;

  struct Control {
    std::int32_t minimum, maximum, step, value;
  };
  /// A finished frame before the flight gets it; `spoil` may change it.
  struct Frame {
    std::int64_t number;
    TimeNs exposed_ns;  ///< start of exposure, mission time
    v4l2_buffer buffer;
    std::vector<std::uint8_t>& bytes;
  };

  explicit ScriptedVideoDevice(VirtualClock& clock) : clock_(clock) {}

  [[nodiscard]] int open(const char* path) override;
  void close() override;
  [[nodiscard]] int control(unsigned long request, void* argument) override;
  [[nodiscard]] int map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) override;
  void unmap(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] int wait(int timeout_ms, bool& readable) override;

  // Properties of the camera and its driver.
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_GREY};
  bool lists_formats = true;
  /// Width and height, px, of pixel formats that have only one size.
  std::map<std::uint32_t, std::pair<std::uint32_t, std::uint32_t>> sizes;
  std::int32_t width = 0, height = 0;  ///< the only size of the camera, px; 0: any requested size
  std::string model = "a camera";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t stride_padding = 0;
  std::uint32_t stated_stride_change = 0, stated_size_change = 0;  ///< stated minus true value, bytes, modulo 2^32
  TimeNs period_ns = 40 * ns_per_ms;
  bool states_rate = true;
  TimeNs first_exposure_ns = 13 * ns_per_ms;
  TimeNs transfer_ns = 30 * ns_per_ms;  ///< time from the start of exposure until the frame is finished
  std::map<std::uint32_t, Control> controls;
  bool present = true;
  bool silent = false;  ///< the camera exposes no frames
  std::uint32_t most_buffers = 32, least_buffers = 0;
  std::uint32_t length_change = 0;
  std::function<void(Frame&)> spoil;
  std::function<std::uint8_t(std::int64_t number, std::int32_t x, std::int32_t y)> picture;
  /// Draws all bytes of a picture, in place of `picture`.
  std::function<void(std::int64_t number, const v4l2_pix_format& format, std::vector<std::uint8_t>& bytes)>
      whole_picture;
  /// For each request, the errno values of its next calls; 0: the call works.
  std::map<unsigned long, std::deque<int>> failures;

  // Records of what happened.
  std::vector<TimeNs> exposures;  ///< start of exposure of all frames for which there was a buffer
  std::int64_t frames_without_buffer = 0;
  std::int64_t frames_taken = 0;
  std::map<unsigned long, int> requests;
  int times_opened = 0;
  int open_attempts = 0;
  std::size_t mapped = 0;
  int longest_wait_ms = 0;
  std::vector<std::string> misuse;  ///< calls that violate the V4L2 interface

 private:
  struct Slot {
    std::vector<std::uint8_t> bytes;
    bool mapped = false;
    bool queued = false;
  };
  void expose_until(TimeNs now);
  void finish_frame(TimeNs exposed_ns);
  void draw(std::vector<std::uint8_t>& bytes, std::int64_t number) const;
  [[nodiscard]] int set_format(v4l2_format& format);
  [[nodiscard]] int request_buffers(v4l2_requestbuffers& request);
  [[nodiscard]] int query_buffer(v4l2_buffer& buffer) const;
  [[nodiscard]] int queue_buffer(const v4l2_buffer& buffer);
  [[nodiscard]] int take_buffer(v4l2_buffer& buffer);
  [[nodiscard]] int query_control(v4l2_queryctrl& control) const;
  [[nodiscard]] int answer(unsigned long request, void* argument);
  void stop();

  VirtualClock& clock_;
  bool open_ = false;
  bool streaming_ = false;
  v4l2_pix_format format_{};
  std::vector<Slot> slots_;
  std::deque<std::uint32_t> queue_;
  std::deque<v4l2_buffer> finished_;
  std::int64_t number_ = 0;
  std::uint32_t sequence_ = 0;
  TimeNs next_exposure_ns_ = 0;
};

}  // namespace ilp::test
