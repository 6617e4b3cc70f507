#include "fsw/components/acquisition.hpp"

#include <deque>
#include <memory>

#include "tests/unit/components/component_fixture.hpp"

namespace ilp {
namespace {

/// Hands over what the test has put into it, in that order.
class ScriptedCamera final : public Camera {
 public:
  Status capture(TimeNs, FrameImage& image, CameraFrame& frame) override {
    if (script.empty()) return StatusCode::not_ready;
    frame = script.front();
    script.pop_front();
    return image.resize(4, 4);
  }
  std::deque<CameraFrame> script;
};

class AcquisitionTest : public test::ComponentTest {
 protected:
  AcquisitionTest() { EXPECT_TRUE(acquisition->restore().ok()); }

  /// The camera hands over a frame at `at_s`, stamped with `stamp_s`; what acquisition has to say about it.
  std::vector<Status> frame(std::int64_t sequence, double stamp_s, double at_s) {
    clock.set(static_cast<TimeNs>(at_s * 1e9));
    CameraFrame taken;
    taken.sequence = sequence;
    taken.time_ns = static_cast<TimeNs>(stamp_s * 1e9);
    camera.script.push_back(taken);
    return run(*acquisition);
  }
  std::vector<Status> frame(std::int64_t sequence, double time_s) { return frame(sequence, time_s, time_s); }
  /// Time passes without a frame, a minor frame of 100 ms after another.
  std::vector<Status> wait_until(double time_s) {
    std::vector<Status> all;
    while (clock.now() < static_cast<TimeNs>(time_s * 1e9)) {
      clock.set(clock.now() + 100 * ns_per_ms);
      for (const Status& status : run(*acquisition)) all.push_back(status);
    }
    return all;
  }

  ScriptedCamera camera;
  std::unique_ptr<Acquisition> acquisition = std::make_unique<Acquisition>(store, camera, clock, mission);
};

#define EXPECT_SAYS(statuses, wanted, value_a, value_b) \
  do {                                                  \
    const std::vector<Status> said = statuses;          \
    ASSERT_EQ(said.size(), 1U);                         \
    EXPECT_STREQ(status_name(said[0].code), #wanted);   \
    EXPECT_EQ(said[0].a, value_a);                      \
    EXPECT_EQ(said[0].b, value_b);                      \
  } while (false)

TEST_F(AcquisitionTest, OneStampAheadOfTheClockCostsOneFrameOnly) {
  EXPECT_TRUE(frame(1, 0).empty());
  EXPECT_SAYS(frame(2, 1000, 2), time_ahead, 2, 998 * ns_per_s);
  EXPECT_TRUE(frame(3, 4).empty());
  EXPECT_TRUE(frame(4, 6).empty());
  EXPECT_EQ(number_of<FrameRecord>(), 3);
}

TEST_F(AcquisitionTest, AStampFromThePastCostsOneFrameOnly) {
  EXPECT_TRUE(frame(1, 10).empty());
  EXPECT_SAYS(frame(2, 4, 12), time_not_monotonic, 2, 6 * ns_per_s);
  EXPECT_TRUE(frame(3, 14).empty());
  EXPECT_EQ(number_of<FrameRecord>(), 2);
}

TEST_F(AcquisitionTest, ARepeatedFrameIsStoredOnce) {
  EXPECT_TRUE(frame(1, 0).empty());
  EXPECT_SAYS(frame(1, 0, 0.5), frame_duplicated, 1, 0);
  EXPECT_TRUE(frame(2, 2).empty());
  EXPECT_EQ(number_of<FrameRecord>(), 2);
}

TEST_F(AcquisitionTest, AFrameThatWasOvertakenIsNotStoredBehindTheOthers) {
  EXPECT_TRUE(frame(1, 0).empty());
  EXPECT_SAYS(frame(3, 4), frame_gap, 3, 1);
  EXPECT_SAYS(frame(2, 2, 5), frame_out_of_order, 2, 3);
  EXPECT_TRUE(frame(4, 6).empty()) << "it is missing no more than once";
  EXPECT_EQ(number_of<FrameRecord>(), 3);
}

TEST_F(AcquisitionTest, FramesThatWereLeftOutAreNotMissing) {
  EXPECT_TRUE(frame(1, 0).empty());
  EXPECT_EQ(frame(2, 1000, 2).size(), 1U);
  EXPECT_SAYS(frame(5, 8), frame_gap, 5, 2);
}

TEST_F(AcquisitionTest, ASilentCameraIsReportedOnceAndHeardAgain) {
  for (int n = 1; n <= 4; ++n) EXPECT_TRUE(frame(n, 2.0 * n).empty());
  EXPECT_TRUE(wait_until(17.9).empty());
  EXPECT_SAYS(wait_until(100), camera_silent, 4, 10'000);
  EXPECT_TRUE(frame(5, 102).empty());
  EXPECT_EQ(wait_until(600).size(), 1U) << "a second silence is news";
}

TEST_F(AcquisitionTest, ACameraOfSlowPaceIsNotSilent) {
  for (int n = 1; n <= 4; ++n) {
    EXPECT_TRUE(wait_until(30.0 * n).empty());
    EXPECT_TRUE(frame(n, 30.0 * n).empty());
  }
}

TEST_F(AcquisitionTest, WhatTheSourceRepeatsAfterARestartIsNoNews) {
  for (int n = 1; n <= 3; ++n) EXPECT_TRUE(frame(n, 2.0 * n).empty());
  acquisition = std::make_unique<Acquisition>(store, camera, clock, mission);
  ASSERT_TRUE(acquisition->restore().ok());
  for (int n = 1; n <= 3; ++n) EXPECT_TRUE(frame(n, 2.0 * n).empty());
  EXPECT_TRUE(frame(4, 8).empty());
  EXPECT_EQ(number_of<FrameRecord>(), 4);
}

}  // namespace
}  // namespace ilp
