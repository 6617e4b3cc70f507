// A device that goes away and comes back as another one.
#include <cmath>
#include <string>

#include "hal/camera/v4l2/pixel_format.hpp"
#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

using test::ScriptedVideoDevice;
using test::V4l2Flight;

constexpr std::uint32_t no_format_of_ours = v4l2_fourcc('H', '2', '6', '4');

struct Another {
  std::uint32_t format = V4L2_PIX_FMT_GREY;
  std::int32_t size_percent = 100;
  bool other_name = false;
  enum class Controls : std::uint8_t { same, narrow, none } controls = Controls::same;
  bool wrong_stamps = false;
  bool slow = false;  ///< ten frames per second, which it does not state

  [[nodiscard]] bool understood() const { return format != no_format_of_ours && format != V4L2_PIX_FMT_MJPEG; }
  [[nodiscard]] std::string text() const {
    return std::string(fourcc_text(format).text) + ", " + std::to_string(size_percent) + " %, " +
           (other_name ? "another name, controls " : "the same name, controls ") +
           std::to_string(static_cast<int>(controls)) + (wrong_stamps ? ", wrong stamps" : "") + (slow ? ", slow" : "");
  }
};

class V4l2Changes : public V4l2Flight {
 protected:
  static constexpr ExposureSetting asked{4000, 1500};

  void give_controls(std::int32_t most_exposure) {
    device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {1, most_exposure, 1, 10};
    device.controls[V4L2_CID_GAIN] = {16, 64, 1, 16};
  }
  void become_first() {
    device.formats = {V4L2_PIX_FMT_GREY};
    device.width = device.height = 0;
    device.model = "a camera";
    give_controls(1000);
    device.spoil = nullptr;
    device.period_ns = 40 * ns_per_ms;
    device.states_rate = true;
  }
  void become(const Another& other) {
    device.formats = {other.format};
    device.width = width * other.size_percent / 100;
    device.height = height * other.size_percent / 100;
    if (other.other_name) device.model = "another camera";
    if (other.controls == Another::Controls::narrow) give_controls(20);
    if (other.controls == Another::Controls::none) device.controls.clear();
    if (other.wrong_stamps) {
      device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.timestamp = {1'800'000'000, 0}; };
    }
    if (other.slow) device.period_ns = 100 * ns_per_ms;
    device.states_rate = !other.slow;
  }
  void unplug() {
    device.present = false;
    fly(0.5);
    device.present = true;
  }
  /// All frames that were given since `first` are true about their times, and about their exposure.
  void expect_true(std::size_t first, const Another& other) {
    for (std::size_t i = first; i < given.size(); ++i) {
      const CameraFrame& frame = given[i].frame;
      const double off_ms = std::abs(static_cast<double>(frame.time_ns - nearest_exposure(frame.time_ns))) / 1e6;
      ASSERT_LE(off_ms, other.wrong_stamps ? static_cast<double>(device.period_ns) / 1e6 : 0.001) << other.text();
      if (!frame.exposure.known()) continue;
      ASSERT_NE(other.controls, Another::Controls::none) << other.text();
      ASSERT_EQ(frame.exposure.exposure_us, other.controls == Another::Controls::narrow ? 2000 : asked.exposure_us)
          << other.text();
    }
  }
  void change_and_return(const Another& other) {
    become_first();
    ASSERT_OK(prepare());
    every_frame = true;
    ExposureRange range;
    ASSERT_OK(camera->exposure_range(range));
    ExposureSetting setting = asked;
    ASSERT_OK(camera->set_exposure(setting));
    fly(1);
    ASSERT_GE(given.size(), 20U);
    events.clear();
    device.exposures.clear();

    unplug();
    become(other);
    std::size_t before = given.size();
    fly(1);
    EXPECT_TRUE(!other.other_name || given.size() == before) << "not before its driver is graded: " << other.text();
    fly(7);
    const bool flown = other.understood() && other.size_percent == 100;
    EXPECT_EQ(given.size() > before + 15, flown) << other.text() << ": " << given.size() - before << " frames";
    EXPECT_TRUE(flown || given.size() == before) << other.text();
    if (flown) expect_true(before, other);
    EXPECT_EQ(events_of(StatusCode::camera_changed).size(), other.other_name ? 1U : 0U) << other.text();
    EXPECT_EQ(events_of(StatusCode::camera_size).size(), other.size_percent != 100 && other.format != no_format_of_ours)
        << other.text();
    EXPECT_EQ(events_of(StatusCode::unsupported_format).size(), other.format == no_format_of_ours) << other.text();
    if (other.other_name && flown) {
      EXPECT_EQ(events_of(StatusCode::camera_graded).size() + events_of(StatusCode::camera_distrusted).size(), 1U)
          << other.text();
    }
    // What is known of one device says nothing of another.
    const bool updates = other.other_name && other.format != no_format_of_ours && other.size_percent == 100;
    EXPECT_EQ(events_of(StatusCode::camera_control_missing).size(),
              updates && other.controls == Another::Controls::none ? 2U : 0U)
        << other.text();
    EXPECT_LE(events.size(), 8U) << other.text();

    unplug();
    become_first();
    events.clear();
    fly(12);
    before = given.size();
    fly(1);
    EXPECT_GE(given.size() - before, 20U) << "after " << other.text();
    EXPECT_EQ(events_of(StatusCode::camera_changed).size(), 0U) << "the first one is known: " << other.text();
    for (std::size_t i = 1; i < given.size(); ++i) {
      ASSERT_GT(given[i].frame.time_ns, given[i - 1].frame.time_ns) << other.text();
      ASSERT_EQ(given[i].frame.sequence, given[i - 1].frame.sequence + 1) << other.text();
    }
  }
};

TEST_F(V4l2Changes, WhateverComesBackIsFlownTrulyOrNotAndTheFirstOneIsFlownAgain) {
  options.exposure_us = 4000;
  options.gain = 20;
  int changes = 0;
  Another other;
  for (const std::uint32_t format :
       {std::uint32_t{V4L2_PIX_FMT_GREY}, std::uint32_t{V4L2_PIX_FMT_YUYV}, std::uint32_t{V4L2_PIX_FMT_NV12},
        std::uint32_t{V4L2_PIX_FMT_SRGGB8}, std::uint32_t{V4L2_PIX_FMT_MJPEG}, no_format_of_ours}) {
    for (int rest = 0; rest < 72; ++rest) {
      other.format = format;
      other.size_percent = rest % 3 == 0 ? 100 : rest % 3 == 1 ? 200 : 50;
      other.other_name = rest / 3 % 2 != 0;
      other.controls = static_cast<Another::Controls>(rest / 6 % 3);
      other.wrong_stamps = rest / 18 % 2 != 0;
      other.slow = rest / 36 % 2 != 0;
      change_and_return(other);
      if (HasFatalFailure()) return;
      ++changes;
      camera = std::make_unique<V4l2Camera>(device, clock);
      given.clear();
    }
  }
  std::printf("%d devices that came back as another one\n", changes);
}

}  // namespace
}  // namespace ilp
