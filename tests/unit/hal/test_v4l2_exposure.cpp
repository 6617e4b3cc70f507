// Exposure and gain of a V4L2 camera that the flight sets while frames come.
#include <string>

#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

class V4l2Exposure : public test::V4l2Flight {
 protected:
  void give_controls() {
    device.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, 1, 3};
    device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {3, 2047, 1, 250};
    device.controls[V4L2_CID_AUTOGAIN] = {0, 1, 1, 1};
    device.controls[V4L2_CID_GAIN] = {16, 255, 1, 90};
  }
  [[nodiscard]] std::int32_t value(std::uint32_t id) { return device.controls.at(id).value; }
};

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

TEST_F(V4l2Exposure, RangesAreThoseOfTheDriverAndItsAutomaticControlsGoOff) {
  give_controls();
  ASSERT_OK(prepare());
  ExposureRange range;
  ASSERT_OK(camera->exposure_range(range));
  EXPECT_EQ(range.least_us, 300);
  EXPECT_EQ(range.most_us, 204'700);
  EXPECT_EQ(range.step_us, 100);
  EXPECT_EQ(range.least_gain_milli, 1000);
  EXPECT_EQ(range.most_gain_milli, 1000 + 1000 * (255 - 16) / 16);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(value(V4L2_CID_AUTOGAIN), 0);
}

TEST_F(V4l2Exposure, AFrameSaysTheSettingThatItWasCertainlyTakenWith) {
  give_controls();
  ASSERT_OK(prepare());
  ExposureRange range;
  ASSERT_OK(camera->exposure_range(range));
  ExposureSetting setting{2070, 2500};
  ASSERT_OK(camera->set_exposure(setting));
  EXPECT_EQ(setting, (ExposureSetting{2000, 2500}));
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_ABSOLUTE), 20);
  EXPECT_EQ(value(V4L2_CID_GAIN), 16 + 24);
  const TimeNs set = clock.now();
  // The sensor may have begun this frame before the setting.
  take(set + device.period_ns);
  EXPECT_FALSE(given.back().frame.exposure.known());
  take(set + ns_per_s);
  EXPECT_EQ(given.back().frame.exposure, setting);
  EXPECT_TRUE(ends_with(given.back().frame.name, "-2000us-gain2500")) << given.back().frame.name;
}

TEST_F(V4l2Exposure, WithoutASettingFramesHaveTheNamesThatTheyHad) {
  give_controls();
  ASSERT_OK(prepare());
  take(clock.now() + ns_per_s);
  EXPECT_FALSE(given.back().frame.exposure.known());
  EXPECT_EQ(std::string(given.back().frame.name).find("us-gain"), std::string::npos);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), 3);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_ABSOLUTE), 250);
}

TEST_F(V4l2Exposure, ACameraWithoutTheControlSaysWhich) {
  ASSERT_OK(prepare());
  ExposureRange range;
  const Status missing = camera->exposure_range(range);
  EXPECT_TRUE(missing.is(StatusCode::camera_control_missing));
  EXPECT_EQ(missing.a, V4L2_CID_EXPOSURE_ABSOLUTE);
}

TEST_F(V4l2Exposure, ACameraWithoutGainHasOne) {
  give_controls();
  device.controls.erase(V4L2_CID_GAIN);
  device.controls.erase(V4L2_CID_AUTOGAIN);
  ASSERT_OK(prepare());
  ExposureRange range;
  ASSERT_OK(camera->exposure_range(range));
  EXPECT_EQ(range.most_gain_milli, 1000);
  ExposureSetting setting{1000, 4000};
  ASSERT_OK(camera->set_exposure(setting));
  EXPECT_EQ(setting, (ExposureSetting{1000, 1000}));
}

TEST_F(V4l2Exposure, ACameraThatIsNotThereYetIsAskedLater) {
  give_controls();
  configure();
  ExposureRange range;
  EXPECT_TRUE(camera->exposure_range(range).is(StatusCode::not_ready));
  ExposureSetting setting{1000, 1000};
  EXPECT_TRUE(camera->set_exposure(setting).is(StatusCode::not_ready));
}

TEST_F(V4l2Exposure, AfterAnOutageTheSettingIsThereAgain) {
  give_controls();
  ASSERT_OK(prepare());
  ExposureRange range;
  ASSERT_OK(camera->exposure_range(range));
  ExposureSetting setting{4000, 1500};
  ASSERT_OK(camera->set_exposure(setting));
  device.present = false;
  device.failures[VIDIOC_DQBUF] = {ENODEV};
  fly(1);
  // Plugged in again, it has the settings of its start-up.
  give_controls();
  device.present = true;
  fly(5);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_ABSOLUTE), 40);
  EXPECT_EQ(value(V4L2_CID_GAIN), 24);
  take(clock.now() + ns_per_s);
  EXPECT_EQ(given.back().frame.exposure, setting);
}

}  // namespace
}  // namespace ilp
