// Exposure by the flight, as Acquisition drives it: from the image, the records and the parameters to the camera.
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

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
    if (sets <= busy_sets) return StatusCode::not_ready;
    if (refuses) return StatusCode::io_error;
    setting = wanted;
    return {};
  }

  bool settable = true;
  bool refuses = false;
  int busy_sets = 0;  ///< settings before it is ready for one
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
  void make_first_frame_keyframe() {
    KeyframeRecord keyframe{.id = 1, .frame_id = 1};
    write(keyframe);
  }
  /// The overlap checker's result for the latest frame: the ground has moved by `pixels` since the first frame.
  void see_ground_moving(double pixels, double rotation_rad = 0, double scale = 1) {
    OverlapRecord overlap;
    overlap.id = camera.taken;
    overlap.keyframe_id = 1;
    overlap.verdict = OverlapVerdict::ok;
    overlap.shift_x_px = pixels;
    overlap.rotation_rad = rotation_rad;
    overlap.scale = scale;
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

TEST_F(ExposureAcquisition, TheMissionsGoalAndBoundsAreKept) {
  mission.exposure_control = true;
  mission.exposure_bright_grey = 100;
  fly(8);
  const double wanted_us = 4000.0 * 100 / 255;
  EXPECT_NEAR(static_cast<double>(camera.setting.exposure_us), wanted_us, wanted_us / 7);
  mission.exposure_longest_us = 600;
  fly(4);
  EXPECT_EQ(camera.setting.exposure_us, 600);
  EXPECT_NEAR(1e-3 * static_cast<double>(camera.setting.gain_milli), wanted_us / 600, wanted_us / 600 / 7);
  EXPECT_EQ(events_of(StatusCode::exposure_limited), 0U);
  mission.exposure_most_gain = 2;
  fly(4);
  EXPECT_EQ(camera.setting, (ExposureSetting{600, 2000}));
  EXPECT_EQ(events_of(StatusCode::exposure_limited), 1U);
}

TEST_F(ExposureAcquisition, TheMeasuredSpeedOfTheGroundBoundsTheExposure) {
  mission.exposure_control = true;
  mission.exposure_blur_px = 0.4;
  fly(8);
  make_first_frame_keyframe();
  see_ground_moving(2800);  // 400 px/s in the seven seconds since the first frame
  fly(4);
  const double wanted_us = 4000.0 * 190 / 255;
  EXPECT_EQ(camera.setting.exposure_us, 1000);
  EXPECT_NEAR(static_cast<double>(camera.setting.gain_milli), wanted_us, wanted_us / 7);
  // The ground stands still: less noise.
  see_ground_moving(0);
  fly(20);
  EXPECT_NEAR(static_cast<double>(camera.setting.gain_milli), 1000, 1000.0 / 16) << "a smaller change is none";
  EXPECT_NEAR(static_cast<double>(camera.setting.exposure_us), wanted_us, wanted_us / 7);
}

class TurningGround : public ExposureAcquisition, public testing::WithParamInterface<std::pair<double, double>> {};

TEST_P(TurningGround, MovesTheCornersOfTheImage) {
  mission.exposure_control = true;
  mission.exposure_blur_px = 0.004;
  fly(8);
  make_first_frame_keyframe();
  const auto [rotation_rad, scale] = GetParam();
  see_ground_moving(0, rotation_rad, scale);
  fly(4);
  // The corner of 64 x 64 pixels lies 32 sqrt(2) px from the centre and has moved by half of that in seven seconds.
  const double bound_us = 1e6 * 0.004 / (0.5 * 32 * std::sqrt(2.0) / 7);
  EXPECT_NEAR(static_cast<double>(camera.setting.exposure_us), bound_us, 10);
}
INSTANTIATE_TEST_SUITE_P(ExposureAcquisition, TurningGround,
                         testing::Values(std::pair{0.5, 1.0}, std::pair{-0.5, 1.0}, std::pair{0.0, 1.5},
                                         std::pair{0.0, 0.5}));

TEST_F(ExposureAcquisition, ACameraThatRefusesASettingIsReportedOnceAndTheFlightGoesOn) {
  mission.exposure_control = true;
  camera.refuses = true;
  fly(6);
  EXPECT_EQ(events_of(StatusCode::exposure_unsupported), 1U);
  EXPECT_EQ(camera.sets, 1);
  EXPECT_EQ(number_of<FrameRecord>(), 6);
}

TEST_F(ExposureAcquisition, ACameraThatIsNotReadyForASettingGetsItLater) {
  mission.exposure_control = true;
  camera.busy_sets = 3;
  fly(10);
  EXPECT_EQ(events_of(StatusCode::exposure_unsupported), 0U);
  EXPECT_NEAR(static_cast<double>(camera.setting.exposure_us), 4000.0 * 190 / 255, 4000.0 * 190 / 255 / 7);
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
