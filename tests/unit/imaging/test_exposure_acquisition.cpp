// Exposure by the flight, as Acquisition drives it: from the image, the records and the parameters to the camera.
#include <cstring>
#include <memory>
#include <optional>

#include "fsw/imaging/acquisition.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

/// Sees ground whose bright end is grey 255 at 4 ms and gain 1. It gives an image every second.
class SettableCamera final : public Camera {
 public:
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    if ((taken + 1) * ns_per_s > now) return StatusCode::not_ready;
    frame = {};
    frame.sequence = ++taken;
    frame.time_ns = taken * ns_per_s;
    if (settable) frame.exposure = setting;
    EXPECT_TRUE(image.resize(64, 64).ok());
    const double share = 1e-3 * static_cast<double>(setting.gain_milli * setting.exposure_us) / 4000;
    const auto grey = static_cast<std::uint8_t>(std::min(255.0, 255 * share));
    std::memset(image.view().data, grey, image.view().area());
    image.view().data[taken % 64] = static_cast<std::uint8_t>(taken);
    return {};
  }
  Status exposure_range(ExposureRange& range) override {
    ++asked;
    range = {.least_us = 10, .most_us = 50'000, .step_us = 10, .least_gain_milli = 1000, .most_gain_milli = 16'000};
    return settable ? Status{} : Status{StatusCode::camera_control_missing, 77};
  }
  Status set_exposure(ExposureSetting& wanted) override {
    ++sets;
    setting = wanted;
    return {};
  }

  bool settable = true;
  ExposureSetting setting{500, 1000};
  std::int64_t taken = 0;
  int asked = 0;
  int sets = 0;
};

class ExposureAcquisition : public test::ComponentTest {
 protected:
  ExposureAcquisition() { EXPECT_TRUE(acquisition->restore().ok()); }

  void fly(int images) {
    for (int k = 0; k < images; ++k) {
      clock.set((camera.taken + 1) * ns_per_s);
      for (const Status& event : run(*acquisition)) events.push_back(event);
    }
  }
  [[nodiscard]] std::size_t events_of(StatusCode code) const {
    std::size_t count = 0;
    for (const Status& event : events) count += event.is(code) ? 1 : 0;
    return count;
  }
  /// The overlap checker's result for the latest frame: the ground has moved by `pixels` since the first frame.
  void see_ground_moving(double pixels) {
    KeyframeRecord keyframe;
    keyframe.id = 1;
    keyframe.frame_id = 1;
    write(keyframe);
    OverlapRecord overlap;
    overlap.id = camera.taken;
    overlap.keyframe_id = 1;
    overlap.verdict = OverlapVerdict::ok;
    overlap.shift_x_px = pixels;
    write(overlap);
  }

  std::vector<Status> events;
  SettableCamera camera;
  std::unique_ptr<Acquisition> acquisition = std::make_unique<Acquisition>(store, camera, clock, mission);
};

TEST_F(ExposureAcquisition, NothingIsAskedOrSetUnlessTheMissionSaysSo) {
  fly(6);
  EXPECT_EQ(camera.asked, 0);
  EXPECT_EQ(camera.sets, 0);
  EXPECT_TRUE(events.empty());
}

TEST_F(ExposureAcquisition, ADarkImageGetsALongerExposureAndTheEventSaysWhich) {
  mission.exposure_control = true;
  fly(8);
  EXPECT_NEAR(static_cast<double>(camera.setting.exposure_us), 4000.0 * 190 / 255, 4000.0 * 190 / 255 / 7);
  EXPECT_EQ(camera.setting.gain_milli, 1000);
  ASSERT_GE(events_of(StatusCode::exposure_changed), 1U);
  EXPECT_EQ(events_of(StatusCode::exposure_changed), static_cast<std::size_t>(camera.sets));
  EXPECT_EQ(events.back().a, camera.setting.exposure_us);
  EXPECT_EQ(events.back().b, camera.setting.gain_milli);
  EXPECT_EQ(number_of<FrameRecord>(), 8);
}

TEST_F(ExposureAcquisition, TheMeasuredSpeedOfTheGroundBoundsTheExposure) {
  mission.exposure_control = true;
  mission.exposure_blur_px = 0.4;
  fly(8);
  see_ground_moving(2800);  // 400 px/s in the seven seconds since the first frame
  fly(4);
  EXPECT_EQ(camera.setting.exposure_us, 1000);
  EXPECT_NEAR(static_cast<double>(camera.setting.gain_milli), 4000.0 * 190 / 255, 4000.0 * 190 / 255 / 7);
}

TEST_F(ExposureAcquisition, ACameraWithoutTheControlIsReportedOnceAndTheFlightGoesOn) {
  mission.exposure_control = true;
  camera.settable = false;
  fly(5);
  EXPECT_EQ(events_of(StatusCode::exposure_unsupported), 1U);
  EXPECT_EQ(camera.asked, 1);
  EXPECT_EQ(camera.sets, 0);
  EXPECT_EQ(number_of<FrameRecord>(), 5);
  // Off and on again by telecommand: another attempt.
  mission.exposure_control = false;
  fly(1);
  mission.exposure_control = true;
  camera.settable = true;
  fly(4);
  EXPECT_GT(camera.sets, 0);
}

TEST_F(ExposureAcquisition, AfterARestartTheControlGoesOnFromTheCamerasSetting) {
  mission.exposure_control = true;
  fly(8);
  const ExposureSetting before = camera.setting;
  ASSERT_TRUE(acquisition->restore().ok());
  fly(4);
  EXPECT_EQ(camera.setting, before);
}

}  // namespace
}  // namespace ilp
