// A V4L2 camera in minor frames, over a scripted device.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "hal/camera/v4l2/v4l2_camera.hpp"
#include "tests/support/scripted_video_device.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp::test {

class V4l2Flight : public ::testing::Test {
 protected:
  static constexpr TimeNs minor_frame = 100 * ns_per_ms;
  static constexpr std::int32_t width = 80, height = 64;

  struct Given {
    CameraFrame frame;
    TimeNs at_ns = 0;
    std::uint8_t first_pixel = 0;
  };

  ~V4l2Flight() override {
    camera.reset();
    EXPECT_EQ(device.mapped, 0U);
    for (const std::string& misuse : device.misuse) ADD_FAILURE() << misuse;
  }

  void configure() {
    ASSERT_OK(camera->configure(options, width, height, ScriptedVideoDevice::mission_minus_monotonic));
  }
  Status prepare() {
    configure();
    return camera->prepare(5 * ns_per_s);
  }
  /// One minor frame, as Acquisition does it.
  void step() {
    for (int i = 0; i < 200; ++i) {
      if (every_frame || wanted) {
        EXPECT_OK(camera->trigger(every_frame ? Camera::any_time : *wanted));
      }
      CameraFrame frame;
      const Status status = camera->capture(clock.now(), *image, frame);
      if (status.is(StatusCode::not_ready)) break;
      if (status.ok()) {
        given.push_back({frame, clock.now(), image->view().data[0]});
        wanted.reset();
      } else {
        events.push_back(status);
      }
    }
    clock.sleep_until(clock.now() + minor_frame);
  }
  void fly(double seconds) {
    const TimeNs end = clock.now() + static_cast<TimeNs>(seconds * 1e9);
    while (clock.now() < end) step();
  }
  /// Until there is a frame for `time`, or ten seconds have passed.
  void take(TimeNs time) {
    wanted = time;
    for (int i = 0; i < 100 && wanted; ++i) step();
    ASSERT_FALSE(wanted) << "no frame";
  }
  [[nodiscard]] std::vector<Status> events_of(StatusCode code) const {
    std::vector<Status> found;
    std::copy_if(events.begin(), events.end(), std::back_inserter(found),
                 [code](const Status& event) { return event.is(code); });
    return found;
  }
  /// The exposure that the camera could have given for this time.
  [[nodiscard]] TimeNs nearest_exposure(TimeNs time) const {
    TimeNs best = device.exposures.front();
    for (const TimeNs exposed : device.exposures) {
      if (std::abs(exposed - time) < std::abs(best - time)) best = exposed;
    }
    return best;
  }

  VirtualClock clock{10 * ns_per_s};
  ScriptedVideoDevice device{clock};
  V4l2Options options;
  std::unique_ptr<V4l2Camera> camera = std::make_unique<V4l2Camera>(device, clock);
  std::unique_ptr<FrameImage> image = std::make_unique<FrameImage>();
  bool every_frame = false;
  std::optional<TimeNs> wanted;
  std::vector<Given> given;
  std::vector<Status> events;
};

}  // namespace ilp::test
