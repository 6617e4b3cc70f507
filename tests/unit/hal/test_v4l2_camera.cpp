// The V4L2 camera with a driver that keeps its word: which frame is given for which time.
#include "fsw/base/rng.hpp"
#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

using test::V4l2Flight;

class V4l2CameraTest : public V4l2Flight {};

TEST_F(V4l2CameraTest, AnHonestDriverIsGradedSo) {
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, 0U);
  EXPECT_EQ(camera->verdict().frames, DriverGrade::frames_wanted);
  EXPECT_EQ(camera->verdict().period_ns, device.period_ns);
  EXPECT_TRUE(camera->verdict().stamps_believed && camera->verdict().sequence_believed);
  fly(1);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_STATUS(events[0], camera_graded);
  EXPECT_EQ(events[0].b, device.period_ns / ns_per_us);
}

TEST_F(V4l2CameraTest, ForAWantedTimeTheNearestFrameIsGiven) {
  for (const TimeNs period : {TimeNs{16'683'350}, 40 * ns_per_ms, 240 * ns_per_ms}) {
    SCOPED_TRACE(period);
    camera = std::make_unique<V4l2Camera>(device, clock);
    device.period_ns = period;
    device.exposures.clear();
    given.clear();
    ASSERT_OK(prepare());
    Rng rng(5);
    for (int i = 0; i < 100; ++i) {
      // Also a little in the past: the newest frames are still there.
      const TimeNs time = clock.now() - 20 * ns_per_ms + static_cast<TimeNs>(rng.uniform() * 2e9);
      ASSERT_NO_FATAL_FAILURE(take(time));
      const TimeNs nearest = nearest_exposure(time);
      EXPECT_LE(std::abs(nearest - time), period / 2 + 1);
      // A driver's stamps are in microseconds.
      EXPECT_NEAR(static_cast<double>(given.back().frame.time_ns), static_cast<double>(nearest), 1000.0);
    }
    EXPECT_EQ(device.frames_without_buffer, 0);
  }
}

TEST_F(V4l2CameraTest, FramesThatNobodyWantsAreNotGivenButTakenFromTheDriver) {
  ASSERT_OK(prepare());
  fly(20);
  EXPECT_TRUE(given.empty());
  EXPECT_EQ(device.frames_without_buffer, 0);
  EXPECT_GT(device.frames_taken, 500);
}

TEST_F(V4l2CameraTest, WhereEveryFrameIsWantedNoneIsMissing) {
  ASSERT_OK(prepare());
  every_frame = true;
  fly(10);
  ASSERT_GE(given.size(), 248U);
  for (std::size_t i = 1; i < given.size(); ++i) {
    EXPECT_EQ(given[i].frame.time_ns - given[i - 1].frame.time_ns, device.period_ns);
    EXPECT_EQ(given[i].frame.sequence, given[i - 1].frame.sequence + 1);
  }
  EXPECT_TRUE(events_of(StatusCode::frame_gap).empty());
}

TEST_F(V4l2CameraTest, APictureBelongsToItsTime) {
  device.picture = [](std::int64_t number, std::int32_t, std::int32_t) { return static_cast<std::uint8_t>(number); };
  ASSERT_OK(prepare());
  const TimeNs begin = device.exposures.front();
  for (int i = 0; i < 20; ++i) {
    ASSERT_NO_FATAL_FAILURE(take(clock.now() + 333 * ns_per_ms));
    const std::int64_t number = (given.back().frame.time_ns - begin) / device.period_ns + 1;
    EXPECT_EQ(given.back().first_pixel, number & 255);
  }
}

TEST_F(V4l2CameraTest, ATimeThatNoFrameIsNearIsLeftAlone) {
  ASSERT_OK(prepare());
  device.silent = true;
  fly(1.5);
  const TimeNs in_the_gap = clock.now() - 700 * ns_per_ms;
  device.silent = false;
  wanted = in_the_gap;
  fly(2);
  EXPECT_TRUE(given.empty());
  wanted = clock.now() + 50 * ns_per_ms;
  fly(0.5);
  EXPECT_EQ(given.size(), 1U) << "the next one is served";
}

TEST_F(V4l2CameraTest, CaptureNeverWaits) {
  ASSERT_OK(prepare());
  device.longest_wait_ms = 0;
  every_frame = true;
  fly(2);
  device.present = false;
  fly(5);
  device.present = true;
  fly(5);
  EXPECT_EQ(device.longest_wait_ms, 0);
}

TEST_F(V4l2CameraTest, TwoBuffersAreEnoughForTheNearestFrame) {
  device.most_buffers = 2;
  device.period_ns = 250 * ns_per_ms;
  ASSERT_OK(prepare());
  for (int i = 0; i < 20; ++i) {
    const TimeNs time = clock.now() + 777 * ns_per_ms;
    ASSERT_NO_FATAL_FAILURE(take(time));
    EXPECT_EQ(given.back().frame.time_ns, nearest_exposure(time));
  }
}

TEST_F(V4l2CameraTest, AnExecutiveThatWasLateGoesOnWithTheNewestFrames) {
  ASSERT_OK(prepare());
  fly(1);
  clock.sleep_until(clock.now() + 20 * ns_per_s);
  wanted = clock.now() + 300 * ns_per_ms;
  const TimeNs time = *wanted;
  fly(1);
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(given[0].frame.time_ns, nearest_exposure(time));
  EXPECT_TRUE(events_of(StatusCode::camera_silent).empty());
  EXPECT_EQ(events_of(StatusCode::frame_gap).size(), 1U);
}

}  // namespace
}  // namespace ilp
