// Drivers whose stamps, counters or pictures are not what they should be: graded, reported, and flown.
#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

using test::ScriptedVideoDevice;
using test::V4l2Flight;

class V4l2TimesTest : public V4l2Flight {
 protected:
  void stamp(v4l2_buffer& buffer, TimeNs mission_time) {
    const TimeNs monotonic = mission_time - ScriptedVideoDevice::mission_minus_monotonic;
    buffer.timestamp.tv_sec = monotonic / ns_per_s;
    buffer.timestamp.tv_usec = monotonic % ns_per_s / ns_per_us;
  }
  /// Distrusted for `findings`; still every frame comes, its time rises, and is off by less than a minor frame.
  void expect_flown_by_arrival(std::uint32_t findings) {
    ASSERT_OK(prepare());
    EXPECT_EQ(camera->verdict().findings & findings, findings);
    EXPECT_FALSE(camera->verdict().stamps_believed);
    every_frame = true;
    device.exposures.clear();
    fly(10);
    EXPECT_EQ(events_of(StatusCode::camera_distrusted).size(), 1U);
    ASSERT_GE(given.size(), 245U);
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (i > 0) {
        EXPECT_GT(given[i].frame.time_ns, given[i - 1].frame.time_ns);
      }
      EXPECT_LE(given[i].frame.time_ns, given[i].at_ns);
      EXPECT_LE(std::abs(given[i].frame.time_ns - nearest_exposure(given[i].frame.time_ns)), 60 * ns_per_ms);
    }
    EXPECT_NE(std::string(given[0].frame.name).find("-arrival"), std::string::npos);
  }
};

TEST_F(V4l2TimesTest, StampsInTheFutureAreReplacedByArrival) {
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) { stamp(frame.buffer, frame.exposed_ns + ns_per_s); };
  expect_flown_by_arrival(finding::stamps_ahead);
}

TEST_F(V4l2TimesTest, ConstantStampsAreReplacedByArrival) {
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) { stamp(frame.buffer, 10 * ns_per_s); };
  expect_flown_by_arrival(finding::stamps_stand);
}

TEST_F(V4l2TimesTest, StampsOfAWallClockAreReplacedByArrival) {
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) {
    stamp(frame.buffer, frame.exposed_ns + 1'795'000'000 * ns_per_s);
  };
  expect_flown_by_arrival(finding::stamps_elsewhere);
}

TEST_F(V4l2TimesTest, ZeroStampsAreReplacedByArrival) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.timestamp = {}; };
  expect_flown_by_arrival(finding::stamps_stand | finding::stamps_elsewhere);
}

TEST_F(V4l2TimesTest, StampsThatAreNoTimesAreReplacedByArrival) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) {
    frame.buffer.timestamp.tv_sec = frame.number % 2 == 0 ? -5 : std::numeric_limits<time_t>::max();
    frame.buffer.timestamp.tv_usec = -1;
  };
  expect_flown_by_arrival(finding::stamps_elsewhere);
}

TEST_F(V4l2TimesTest, ArrivalFollowsTheRhythmOfTheFrames) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.timestamp = {}; };
  ASSERT_OK(prepare());
  every_frame = true;
  fly(2);
  const std::size_t settled = given.size();
  fly(10);
  // Taken up to a minor frame after they came, they still lie a period apart.
  for (std::size_t i = settled + 1; i < given.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(given[i].frame.time_ns - given[i - 1].frame.time_ns), 40e6, 10e6);
  }
}

TEST_F(V4l2TimesTest, SingleBadStampsAreReplacedAndToldTogether) {
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) {
    if (frame.number % 50 == 45) stamp(frame.buffer, frame.exposed_ns + 3 * ns_per_s);
  };
  ASSERT_OK(prepare());
  EXPECT_TRUE(camera->verdict().stamps_believed);
  every_frame = true;
  fly(60);
  for (std::size_t i = 1; i < given.size(); ++i) {
    EXPECT_GT(given[i].frame.time_ns, given[i - 1].frame.time_ns);
    EXPECT_LE(given[i].frame.time_ns, given[i].at_ns);
  }
  const auto reported = events_of(StatusCode::camera_stamps_refused);
  EXPECT_GE(reported.size(), 2U);
  EXPECT_LE(reported.size(), 7U) << "not one for each";
}

TEST_F(V4l2TimesTest, StampsAtTheEndOfTheFrameCountFromAPeriodBefore) {
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) {
    frame.buffer.flags &= ~static_cast<std::uint32_t>(V4L2_BUF_FLAG_TSTAMP_SRC_MASK);
    stamp(frame.buffer, frame.exposed_ns + device.transfer_ns);
  };
  ASSERT_OK(prepare());
  every_frame = true;
  fly(0.5);
  ASSERT_FALSE(given.empty());
  const TimeNs time = given[0].frame.time_ns;
  EXPECT_EQ(time, nearest_exposure(time) + device.transfer_ns - device.period_ns);
  EXPECT_NE(std::string(given[0].frame.name).find("-end-of-frame"), std::string::npos);
}

TEST_F(V4l2TimesTest, AKnownDelayOfTheStampIsTakenOff) {
  options.stamp_delay_us = 30'000;
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) {
    frame.buffer.flags &= ~static_cast<std::uint32_t>(V4L2_BUF_FLAG_TSTAMP_SRC_MASK);
    stamp(frame.buffer, frame.exposed_ns + device.transfer_ns);
  };
  ASSERT_OK(prepare());
  wanted = clock.now() + 100 * ns_per_ms;
  const TimeNs time = *wanted;
  fly(0.5);
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(given[0].frame.time_ns, nearest_exposure(time));
}

TEST_F(V4l2TimesTest, AConstantSequenceIsFoundAndFlown) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.sequence = 7; };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, finding::sequence_stands);
  every_frame = true;
  fly(5);
  EXPECT_GE(given.size(), 120U);
  EXPECT_TRUE(events_of(StatusCode::frame_gap).empty());
}

TEST_F(V4l2TimesTest, ASequenceThatWrapsIsNoGap) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.sequence += 0xFFFF'FFE0U; };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, 0U);
  fly(5);
  EXPECT_TRUE(events_of(StatusCode::frame_gap).empty());
}

TEST_F(V4l2TimesTest, GapsAreCountedAndToldTogether) {
  ASSERT_OK(prepare());
  fly(1);
  std::int64_t lost = 0;
  device.spoil = [&lost](ScriptedVideoDevice::Frame& frame) {
    if (frame.number % 10 == 0) lost += 2;
    frame.buffer.sequence += static_cast<std::uint32_t>(lost);
  };
  fly(60);
  device.spoil = [&lost](ScriptedVideoDevice::Frame& frame) {
    frame.buffer.sequence += static_cast<std::uint32_t>(lost);
  };
  fly(20);
  std::int64_t reported = 0;
  for (const Status& gap : events_of(StatusCode::frame_gap)) reported += gap.b;
  EXPECT_EQ(reported, lost);
  EXPECT_LE(events_of(StatusCode::frame_gap).size(), 8U);
}

TEST_F(V4l2TimesTest, ADriverThatLosesOneFrameOfFiveIsFound) {
  std::uint32_t lost = 0;
  device.spoil = [&lost](ScriptedVideoDevice::Frame& frame) { frame.buffer.sequence += lost += frame.number % 4 == 0; };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings & finding::frames_missing, finding::frames_missing);
  EXPECT_TRUE(camera->verdict().stamps_believed);
}

TEST_F(V4l2TimesTest, AStuckPictureIsFound) {
  device.picture = [](std::int64_t, std::int32_t x, std::int32_t y) { return static_cast<std::uint8_t>(x * y); };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, finding::frames_stuck);
}

TEST_F(V4l2TimesTest, RepeatedPicturesAndACoveredLensAreNotStuck) {
  device.picture = [](std::int64_t number, std::int32_t x, std::int32_t) {
    return static_cast<std::uint8_t>(number / 5 + x);
  };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, 0U);
  device.picture = [](std::int64_t, std::int32_t, std::int32_t) { return std::uint8_t{3}; };
  camera = std::make_unique<V4l2Camera>(device, clock);
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, 0U);
}

TEST_F(V4l2TimesTest, AnotherRateThanStatedIsFoundAndTheMeasuredOneCounts) {
  device.spoil = [this](ScriptedVideoDevice::Frame& frame) {
    static_cast<void>(frame);
    device.period_ns = 70 * ns_per_ms;
  };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings & finding::rate_differs, finding::rate_differs);
  EXPECT_EQ(camera->verdict().period_ns, 70 * ns_per_ms);
}

TEST_F(V4l2TimesTest, ASlowCameraIsGradedByFewerFrames) {
  device.period_ns = 450 * ns_per_ms;
  ASSERT_OK(prepare());
  EXPECT_GE(camera->verdict().frames, DriverGrade::least_frames);
  EXPECT_LT(camera->verdict().frames, DriverGrade::frames_wanted);
  EXPECT_EQ(camera->verdict().findings, 0U);
}

TEST_F(V4l2TimesTest, BeforeItsVerdictACameraGivesNothing) {
  device.period_ns = 2 * ns_per_s;
  every_frame = true;
  EXPECT_STATUS(prepare(), not_ready);
  fly(8);
  EXPECT_TRUE(given.empty());
  fly(20);
  EXPECT_EQ(events_of(StatusCode::camera_graded).size(), 1U);
  EXPECT_FALSE(given.empty());
}

TEST_F(V4l2TimesTest, TheRateMayChangeInTheDark) {
  ASSERT_OK(prepare());
  device.period_ns = 200 * ns_per_ms;
  fly(30);
  wanted = clock.now() + ns_per_s;
  const TimeNs time = *wanted;
  fly(2);
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(given[0].frame.time_ns, nearest_exposure(time));
  EXPECT_NEAR(static_cast<double>(camera->granularity()), 4e8, 1e7);
}

}  // namespace
}  // namespace ilp
