// Drivers that fail, vanish or break their protocol: reported, bounded, and used again as soon as frames come.
#include <cerrno>

#include "fsw/base/rng.hpp"
#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

using test::ScriptedVideoDevice;
using test::V4l2Flight;

class V4l2FaultTest : public V4l2Flight {
 protected:
  /// Frames come at the camera's rate.
  void expect_flying() {
    every_frame = true;
    const std::size_t before = given.size();
    fly(2);
    EXPECT_GE(given.size() - before, 48U);
  }
  void start_flying() {
    ASSERT_OK(prepare());
    every_frame = true;
    fly(1);
    events.clear();
  }
};

TEST_F(V4l2FaultTest, WithoutACameraTheFlightBeginsAndTheCameraMayCome) {
  device.present = false;
  const Status status = prepare();
  EXPECT_STATUS(status, camera_absent);
  EXPECT_EQ(status.a, ENOENT);
  fly(120);
  EXPECT_EQ(events_of(StatusCode::camera_absent).size(), 1U);
  EXPECT_LE(device.open_attempts, 15) << "at growing intervals";
  device.present = true;
  fly(35);
  EXPECT_EQ(events_of(StatusCode::camera_recovered).size(), 1U);
  EXPECT_EQ(events_of(StatusCode::camera_graded).size(), 1U);
  expect_flying();
}

TEST_F(V4l2FaultTest, AnUnpluggedCameraIsFoundAgain) {
  start_flying();
  device.present = false;
  fly(3);
  const auto faults = events_of(StatusCode::camera_fault);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].a, ENODEV);
  EXPECT_EQ(device.mapped, 0U);
  device.present = true;
  fly(4);
  EXPECT_EQ(events_of(StatusCode::camera_recovered).size(), 1U);
  expect_flying();
  for (std::size_t i = 1; i < given.size(); ++i) {
    EXPECT_GT(given[i].frame.time_ns, given[i - 1].frame.time_ns);
    EXPECT_EQ(given[i].frame.sequence, given[i - 1].frame.sequence + 1);
  }
}

TEST_F(V4l2FaultTest, AStreamThatFailsIsStartedAgainWithoutClosingTheDevice) {
  start_flying();
  device.failures[VIDIOC_DQBUF] = {EIO};
  fly(1);
  ASSERT_EQ(events_of(StatusCode::camera_fault).size(), 1U);
  EXPECT_EQ(events_of(StatusCode::camera_fault)[0].a, EIO);
  EXPECT_EQ(events_of(StatusCode::camera_fault)[0].b, 17);
  ASSERT_EQ(events_of(StatusCode::camera_recovered).size(), 1U);
  EXPECT_LT(events_of(StatusCode::camera_recovered)[0].a, 1000);
  EXPECT_EQ(device.times_opened, 1);
  expect_flying();
}

TEST_F(V4l2FaultTest, RefusedStepsOfAStartAreTriedAgain) {
  for (const unsigned long request :
       {VIDIOC_QUERYCAP, VIDIOC_S_FMT, VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF, VIDIOC_STREAMON}) {
    SCOPED_TRACE(request & 0xFFU);
    camera = std::make_unique<V4l2Camera>(device, clock);
    device.failures.clear();
    // EBUSY, as EINVAL answers VIDIOC_S_FMT for a format that is not there.
    device.failures[request] = {EBUSY};
    ASSERT_OK(prepare());
    expect_flying();
  }
}

TEST_F(V4l2FaultTest, ABufferThatTheDriverRefusedGoesBackLater) {
  start_flying();
  device.failures[VIDIOC_QBUF] = {EINVAL, 0, EINVAL};
  fly(3);
  EXPECT_TRUE(events_of(StatusCode::camera_fault).empty());
  EXPECT_EQ(device.frames_without_buffer, 0);
  expect_flying();
}

TEST_F(V4l2FaultTest, ADriverThatTakesNoBufferBackIsStartedAgain) {
  start_flying();
  device.failures[VIDIOC_QBUF].assign(12, EINVAL);
  fly(10);
  EXPECT_EQ(events_of(StatusCode::camera_fault).size(), 1U);
  EXPECT_EQ(events_of(StatusCode::camera_fault)[0].b, 15);
  EXPECT_EQ(events_of(StatusCode::camera_recovered).size(), 1U);
  expect_flying();
}

TEST_F(V4l2FaultTest, ASilentCameraIsStartedAgainAtGrowingIntervals) {
  start_flying();
  device.silent = true;
  device.requests.clear();
  fly(200);
  EXPECT_EQ(events_of(StatusCode::camera_silent).size(), 1U);
  EXPECT_GE(device.times_opened, 3) << "the device is opened again when starting the stream does not help";
  EXPECT_LE(device.requests[VIDIOC_STREAMON], 20);
  device.silent = false;
  fly(40);
  EXPECT_EQ(events_of(StatusCode::camera_recovered).size(), 1U);
  expect_flying();
}

TEST_F(V4l2FaultTest, AFlappingCameraTellsLittle) {
  start_flying();
  for (int i = 0; i < 100; ++i) {
    device.failures[VIDIOC_DQBUF] = {EIO};
    fly(1);
  }
  EXPECT_EQ(events_of(StatusCode::camera_fault).size(), 1U);
  EXPECT_LE(events_of(StatusCode::camera_recovered).size(), 15U);
  device.failures.clear();
  fly(31);
  expect_flying();
}

TEST_F(V4l2FaultTest, DamagedFramesAreLeftOutAndToldTogether) {
  start_flying();
  device.spoil = [](ScriptedVideoDevice::Frame& frame) {
    if (frame.number % 5 == 0) frame.buffer.flags |= V4L2_BUF_FLAG_ERROR;
    if (frame.number % 5 == 1) --frame.buffer.bytesused;
    if (frame.number % 5 == 2) frame.buffer.bytesused = 0xFFFF'FFFFU;
    frame.bytes[0] = static_cast<std::uint8_t>(frame.number % 5);
  };
  const std::size_t before = given.size();
  fly(30);
  const auto reported = events_of(StatusCode::camera_frames_refused);
  EXPECT_GE(reported.size(), 3U);
  EXPECT_LE(reported.size(), 4U);
  EXPECT_NEAR(static_cast<double>(given.size() - before), 300, 6);
  for (std::size_t i = before + 5; i < given.size(); ++i) EXPECT_GE(given[i].first_pixel, 3);
  EXPECT_TRUE(events_of(StatusCode::frame_gap).empty()) << "they were not lost on the way";
}

TEST_F(V4l2FaultTest, TheFirstFramesOfAStreamAreLeftOutUntilTheyAreConsistent) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) {
    if (frame.number == 1 || frame.number == 3) frame.buffer.flags |= V4L2_BUF_FLAG_ERROR;
  };
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, 0U);
}

TEST_F(V4l2FaultTest, OnlyDamagedFramesGiveNothingAndDoNotEndTheFlight) {
  device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.flags |= V4L2_BUF_FLAG_ERROR; };
  EXPECT_STATUS(prepare(), not_ready);
  every_frame = true;
  fly(30);
  EXPECT_TRUE(given.empty());
  EXPECT_LE(events.size(), 5U);
  device.spoil = nullptr;
  fly(3);
  expect_flying();
}

TEST_F(V4l2FaultTest, ABufferThatDoesNotExistIsNotTouched) {
  for (const std::uint32_t index : {10U, 16U, 0xFFFF'FFFFU}) {
    SCOPED_TRACE(index);
    camera = std::make_unique<V4l2Camera>(device, clock);
    device.spoil = nullptr;
    events.clear();
    start_flying();
    device.spoil = [this, index](ScriptedVideoDevice::Frame& frame) {
      frame.buffer.index = index;
      device.spoil = nullptr;
    };
    fly(1);
    ASSERT_EQ(events_of(StatusCode::camera_protocol).size(), 1U);
    EXPECT_EQ(events_of(StatusCode::camera_protocol)[0].a, index);
    expect_flying();
  }
}

TEST_F(V4l2FaultTest, ABufferThatTheDriverDoesNotHaveEndsTheStream) {
  start_flying();
  // The same buffer in every frame: held by the flight when it comes again.
  device.spoil = [](ScriptedVideoDevice::Frame& frame) { frame.buffer.index = 0; };
  every_frame = false;
  fly(1);
  EXPECT_EQ(events_of(StatusCode::camera_protocol).size(), 1U);
  device.spoil = nullptr;
  device.misuse.clear();
  fly(5);
  expect_flying();
}

TEST_F(V4l2FaultTest, AnotherSizeAfterItsReturnIsToldAndNotFlown) {
  start_flying();
  device.present = false;
  fly(1);
  device.present = true;
  device.width = 2 * width;
  const std::size_t before = given.size();
  fly(10);
  EXPECT_EQ(events_of(StatusCode::camera_size).size(), 1U);
  EXPECT_EQ(given.size(), before);
  device.width = 0;
  fly(60);
  expect_flying();
}

/// Every answer of the driver may be wrong, in any way, for a while.
TEST_F(V4l2FaultTest, WhateverTheDriverSaysTimesRiseAndTheFlightGoesOn) {
  Rng rng(11);
  const auto chance = [&rng](std::uint32_t one_of) { return rng.next() % one_of == 0; };
  start_flying();
  for (int k = 0; k < 200; ++k) {
    device.failures[VIDIOC_DQBUF].assign(rng.next() % 3, static_cast<int>(rng.next() % 40));
    device.failures[VIDIOC_STREAMON].assign(rng.next() % 2, EINVAL);
    device.present = !chance(20);
    device.silent = chance(20);
    device.most_buffers = chance(10) ? rng.next() % 20 : 32;
    device.length_change = chance(20) ? rng.next() % 4096 - 2048 : 0;
    device.spoil = [&](ScriptedVideoDevice::Frame& frame) {
      if (chance(8)) frame.buffer.timestamp = {static_cast<time_t>(rng.next()), static_cast<suseconds_t>(rng.next())};
      if (chance(8)) frame.buffer.sequence = rng.next();
      if (chance(8)) frame.buffer.bytesused = rng.next();
      if (chance(30)) frame.buffer.index = rng.next() % 20;
      if (chance(8)) frame.buffer.flags = rng.next();
    };
    every_frame = chance(2);
    wanted = clock.now() + rng.next() % 3000 * ns_per_ms - ns_per_s;
    fly(2);
  }
  for (std::size_t i = 1; i < given.size(); ++i) {
    EXPECT_GT(given[i].frame.time_ns, given[i - 1].frame.time_ns);
    EXPECT_LE(given[i].frame.time_ns, given[i].at_ns + ns_per_ms);
  }
  device.failures.clear();
  device.present = true;
  device.silent = false;
  device.most_buffers = 32;
  device.length_change = 0;
  device.spoil = nullptr;
  wanted.reset();
  // This also holds for a driver that handed out a buffer that it did not have.
  device.misuse.clear();
  fly(65);
  expect_flying();
}

}  // namespace
}  // namespace ilp
