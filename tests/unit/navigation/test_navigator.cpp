// The stage that says where keyframes and strips are by the vehicle's own measurements.
#include "fsw/navigation/navigator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr double metres_per_unit = 3;
constexpr TimeNs interval = 10 * ns_per_s;

/// Samples in order of time, from memory.
class FakeSource final : public NavigationSource {
 public:
  Status next(TimeNs now, NavigationSample& sample) override {
    if (at_ == samples.size()) return is_recorded ? StatusCode::end_of_stream : StatusCode::not_ready;
    if (samples[at_].time_ns > now) return StatusCode::not_ready;
    sample = samples[at_++];
    return {};
  }
  [[nodiscard]] bool recorded() const override { return is_recorded; }
  void rewind() { at_ = 0; }

  std::vector<NavigationSample> samples;
  bool is_recorded = true;

 private:
  std::size_t at_ = 0;
};

class NavigatorTest : public test::ComponentTest {
 protected:
  NavigatorTest() {
    mission.use_navigation = true;
    mission.body = Body::mars;
    for (int tenth = 0; tenth <= 1000; ++tenth) {
      NavigationSample sample{.time_ns = tenth * 100 * ns_per_ms, .height_m = 90, .height_sigma_m = 0.5};
      sample.q_cam_from_level[0] = 0;
      sample.q_cam_from_level[1] = 1;
      sample.tilt_sigma_rad = 0.005;
      sample.heading_sigma_rad = 0.005;
      sample.longitude_deg = 100;
      sample.latitude_deg = 20 + 0.4 * tenth / degree_lengths(Body::mars, 20, 0).north_m;
      sample.horizontal_sigma_m = 2;
      source.samples.push_back(sample);
    }
  }
  void see_keyframe(std::int64_t id, std::int64_t strip = 1, double altitude = unknown) {
    KeyframeRecord keyframe{.id = id, .strip_id = strip, .time_ns = id * interval, .altitude = altitude};
    write(keyframe);
  }
  /// 4 m/s to the north, 90 m above the ground, in units of 3 m.
  void pose_keyframe(std::int64_t id, std::int64_t strip = 1, PoseState state = PoseState::final) {
    PoseRecord pose{.id = id, .strip_id = strip, .state = state};
    pose.q_cam_from_world[0] = 0;
    pose.q_cam_from_world[1] = 1;
    pose.centre[1] = 40.0 * static_cast<double>(id - 1) / metres_per_unit;
    pose.ground_distance = 90 / metres_per_unit;
    pose.ground_distance_sigma = 0.01;
    write(pose);
  }
  std::unique_ptr<Navigator> make() {
    auto navigator = std::make_unique<Navigator>(store, clock, mission, &source);
    source.rewind();
    EXPECT_TRUE(restored(navigator->restore()));
    return navigator;
  }

  FakeSource source;
};

TEST_F(NavigatorTest, AFlightWithoutNavigationIsLeftAlone) {
  mission.use_navigation = false;
  see_keyframe(1);
  pose_keyframe(1);
  EXPECT_TRUE(run(*make()).empty());
  EXPECT_EQ(number_of<NavigationRecord>(), 0);
  EXPECT_EQ(number_of<StripFrameRecord>(), 0);
  EXPECT_EQ(number_of<CheckpointRecord>(), 0);
}

TEST_F(NavigatorTest, HeightsThatComeWithTheImagesSetTheMetreTogether) {
  mission.use_navigation = false;
  // The first one is 4 % too high, and the seventh one is no height.
  for (std::int64_t id = 1; id <= 12; ++id) {
    see_keyframe(id, 1, id == 1 ? 93.6 : id == 7 ? std::numeric_limits<double>::infinity() : 90);
    pose_keyframe(id);
  }
  see_keyframe(13, 2);
  pose_keyframe(13, 2);
  EXPECT_TRUE(run(*make()).empty());
  EXPECT_EQ(number_of<NavigationRecord>(), 0) << "the vehicle has measured nothing";
  ASSERT_EQ(number_of<StripFrameRecord>(), 1) << "the second strip has no heights";
  const auto frame = read<StripFrameRecord>(1);
  EXPECT_EQ(frame.through_keyframe_id, 12);
  EXPECT_EQ(frame.heights_used + frame.heights_refused, 11U);
  EXPECT_GT(frame.scale_sigma, 0.002) << "the heights state no error of their own";
  EXPECT_LT(std::fabs(frame.metres_per_unit / metres_per_unit - 1), frame.scale_sigma);
  EXPECT_LT(frame.scale_sigma, 0.01);
  EXPECT_EQ(frame.tilt_sigma_rad, 0);
}

TEST_F(NavigatorTest, TheVehiclesHeightsComeBeforeThoseOfTheImages) {
  for (std::int64_t id = 1; id <= 6; ++id) {
    see_keyframe(id, 1, 180);
    pose_keyframe(id);
  }
  EXPECT_TRUE(run(*make()).empty());
  EXPECT_NEAR(read<StripFrameRecord>(1).metres_per_unit, metres_per_unit, 0.01);
}

TEST_F(NavigatorTest, KeyframesGetMeasurementsAndTheStripItsPlace) {
  for (std::int64_t id = 1; id <= 6; ++id) {
    see_keyframe(id);
    pose_keyframe(id);
  }
  EXPECT_TRUE(run(*make()).empty());
  EXPECT_EQ(number_of<NavigationRecord>(), 6);
  const auto measured = read<NavigationRecord>(3);
  EXPECT_EQ(measured.time_ns, 3 * interval);
  EXPECT_EQ(measured.samples, 11U);
  EXPECT_NEAR(measured.height_m, 90, 1e-6);
  EXPECT_GT(measured.height_sigma_m, 0);
  const auto frame = read<StripFrameRecord>(1);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::ok);
  EXPECT_EQ(frame.through_keyframe_id, 6);
  EXPECT_NEAR(frame.metres_per_unit, metres_per_unit, 0.01);
  EXPECT_EQ(frame.heights_used, 6U);
  EXPECT_EQ(frame.body, Body::mars);
  EXPECT_NEAR(frame.longitude_deg, 100, 1e-6);
  EXPECT_NEAR(frame.latitude_deg, 20 + 40 / degree_lengths(Body::mars, 20, 0).north_m, 1e-6) << "of keyframe 1";
  EXPECT_NEAR(rotation_angle(rotation_from_quaternion(frame.q_level_from_strip)), 0, 1e-6);
}

TEST_F(NavigatorTest, EveryKeyframeGetsARecordAlsoWithoutASource) {
  see_keyframe(1);
  Navigator navigator(store, clock, mission);
  ASSERT_TRUE(restored(navigator.restore()));
  EXPECT_TRUE(run(navigator).empty());
  EXPECT_EQ(read<NavigationRecord>(1).height_sigma_m, 0);
}

TEST_F(NavigatorTest, ALiveSourceIsWaitedForAndThenNoLonger) {
  source.is_recorded = false;
  source.samples.resize(95);
  see_keyframe(1);
  const auto navigator = make();
  clock.set(interval);
  EXPECT_TRUE(run(*navigator).empty());
  EXPECT_EQ(number_of<NavigationRecord>(), 0) << "measurements of this time may still arrive";
  clock.set(interval + 3 * ns_per_s);
  EXPECT_TRUE(run(*navigator).empty());
  EXPECT_EQ(read<NavigationRecord>(1).height_sigma_m, 0) << "the source fell silent 0.6 s before";
}

TEST_F(NavigatorTest, OnlyFinalPosesCountAndAnotherStripBeginsAgain) {
  for (std::int64_t id = 1; id <= 8; ++id) see_keyframe(id, id < 5 ? 1 : 2);
  for (std::int64_t id = 1; id <= 3; ++id) pose_keyframe(id);
  pose_keyframe(4, 1, PoseState::provisional);
  const auto navigator = make();
  EXPECT_TRUE(run(*navigator).empty());
  EXPECT_EQ(read<StripFrameRecord>(1).through_keyframe_id, 3);
  pose_keyframe(4, 1);
  for (std::int64_t id = 5; id <= 8; ++id) pose_keyframe(id, 2, id == 6 ? PoseState::failed : PoseState::final);
  EXPECT_TRUE(run(*navigator).empty());
  EXPECT_EQ(read<StripFrameRecord>(1).through_keyframe_id, 4) << "its pose was provisional and became final";
  EXPECT_EQ(read<StripFrameRecord>(2).heights_used, 3U);
}

TEST_F(NavigatorTest, AStopAfterEachRecordChangesNothing) {
  for (std::int64_t id = 1; id <= 6; ++id) {
    see_keyframe(id);
    pose_keyframe(id);
  }
  // A boot needs two steps to read the samples, and one to write.
  for (int boot = 0; boot < 20; ++boot) {
    const auto navigator = make();
    for (int step = 0; step < 3; ++step) EXPECT_TRUE(navigator->step().status.ok());
  }
  const auto stopped = read<StripFrameRecord>(1);
  std::vector<std::byte> other_region(region.size());
  RamStore other(other_region);
  for (std::int64_t id = 1; id <= 6; ++id) test::write_records(other, read<KeyframeRecord>(id), read<PoseRecord>(id));
  Navigator whole(other, clock, mission, &source);
  source.rewind();
  ASSERT_TRUE(restored(whole.restore()));
  EXPECT_TRUE(run(whole).empty());
  StripFrameRecord expected;
  ASSERT_TRUE(get(other, 1, expected).ok());
  EXPECT_EQ(stopped.metres_per_unit, expected.metres_per_unit);
  EXPECT_EQ(stopped.scale_sigma, expected.scale_sigma);
  EXPECT_EQ(stopped.latitude_deg, expected.latitude_deg);
  EXPECT_EQ(stopped.through_keyframe_id, 6);
}

TEST_F(NavigatorTest, HostileSamplesAreRefusedAndTold) {
  for (std::size_t i = 0; i < source.samples.size(); i += 2) {
    source.samples[i].height_m = std::numeric_limits<double>::quiet_NaN();
  }
  for (std::int64_t id = 1; id <= 4; ++id) {
    see_keyframe(id);
    pose_keyframe(id);
  }
  const std::vector<Status> reported = run(*make());
  ASSERT_GE(reported.size(), 1U);
  EXPECT_LE(reported.size(), 8U) << "not one event per sample";
  for (const Status& status : reported) EXPECT_STATUS(status, navigation_refused);
  EXPECT_GT(reported.back().a, static_cast<std::int64_t>(10 * reported.size())) << "with their number";
  EXPECT_NEAR(read<StripFrameRecord>(1).metres_per_unit, metres_per_unit, 0.01);
}

TEST_F(NavigatorTest, AFlightThatUsesItsMapAloneIsToldNothingOfMeasurements) {
  mission.use_navigation = false;
  mission.use_map = true;
  for (std::int64_t id = 1; id <= 9; ++id) {
    pose_keyframe(id);
    FixRecord fix{.id = id};
    write(fix);
  }
  EXPECT_TRUE(run(*make()).empty());
}

TEST_F(NavigatorTest, MeasurementsOfAnotherTimeAreToldOnceAStrip) {
  for (NavigationSample& sample : source.samples) sample.time_ns += 1000 * ns_per_s;
  for (std::int64_t id = 1; id <= 9; ++id) {
    see_keyframe(id);
    pose_keyframe(id);
  }
  const std::vector<Status> reported = run(*make());
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], navigation_unused);
  EXPECT_EQ(reported[0].a, 1);
  EXPECT_EQ(reported[0].b, 5);
}

TEST_F(NavigatorTest, HeightsOfTheImagesDoNotHideMeasurementsOfAnotherTime) {
  for (NavigationSample& sample : source.samples) sample.time_ns += 3600 * ns_per_s;
  for (std::int64_t id = 1; id <= 8; ++id) {
    see_keyframe(id, 1, 90);
    pose_keyframe(id);
  }
  const std::vector<Status> reported = run(*make());
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], navigation_unused);
  EXPECT_NEAR(read<StripFrameRecord>(1).metres_per_unit, metres_per_unit, 0.01);
}

TEST_F(NavigatorTest, ContradictionsAreToldOnce) {
  for (NavigationSample& sample : source.samples) sample.height_m = 90 / 0.3048;
  for (std::int64_t id = 1; id <= 8; ++id) {
    see_keyframe(id);
    pose_keyframe(id);
  }
  const std::vector<Status> reported = run(*make());
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], navigation_contradicts);
  EXPECT_EQ(reported[0].a, 1);
  EXPECT_EQ(read<StripFrameRecord>(1).scale_sigma, 0);
}

TEST(BodyFigureTest, DegreesHaveThePublishedLengths) {
  // WGS 84 at 45 degrees: 78 847 m and 111 132 m (NGA.STND.0036, 2014).
  EXPECT_NEAR(degree_lengths(Body::earth, 45, 0).east_m, 78847, 1);
  EXPECT_NEAR(degree_lengths(Body::earth, 45, 0).north_m, 111132, 1);
  EXPECT_NEAR(degree_lengths(Body::mars, 0, 0).east_m, 59275, 1);
  EXPECT_NEAR(degree_lengths(Body::mars, 60, 0).east_m, 0.5 * 59275, 1);
  EXPECT_EQ(degree_lengths(Body::none, 45, 0).east_m, 0);
}

}  // namespace
}  // namespace ilp
