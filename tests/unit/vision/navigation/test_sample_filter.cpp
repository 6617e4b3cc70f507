// What samples say about one moment.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/navigation/sample_filter.hpp"

namespace ilp::navigation {
namespace {

constexpr TimeNs moment = 50 * ns_per_s;

NavigationSample height_at(double seconds, double height) {
  NavigationSample sample{
      .time_ns = moment + static_cast<TimeNs>(seconds * 1e9), .height_m = height, .height_sigma_m = 1};
  return sample;
}

TEST(SampleFilterTest, AHeightThatChangesIsThatOfTheMoment) {
  WindowSamples samples;
  // All but one sample lie before the moment: a mean would lag by 3 m.
  for (int i = -4; i <= 1; ++i) {
    ASSERT_TRUE(samples.push_back(height_at(0.1 * i, 100 + 20 * 0.1 * i)));
  }
  SampleCounts counts;
  const NavigationSample at = measure_at(samples, moment, counts);
  EXPECT_NEAR(at.height_m, 100, 0.01);
  EXPECT_GT(at.height_sigma_m, 0.2);
  EXPECT_EQ(counts.offered, 6U);
  EXPECT_EQ(counts.refused, 0U);
  EXPECT_EQ(at.tilt_sigma_rad, 0);
  EXPECT_EQ(at.horizontal_sigma_m, 0);
}

TEST(SampleFilterTest, OutliersAreLeftOutAndCounted) {
  WindowSamples samples;
  for (int i = -5; i <= 5; ++i) {
    const bool wrong = i == 0 || i == 3;
    ASSERT_TRUE(samples.push_back(height_at(0.1 * i, wrong ? 300 : 100 + 0.3 * (i % 3))));
  }
  SampleCounts counts;
  EXPECT_NEAR(measure_at(samples, moment, counts).height_m, 100, 0.6);
  EXPECT_EQ(counts.refused, 2U);
}

TEST(SampleFilterTest, SamplesFarToOneSideSayNothing) {
  WindowSamples samples;
  for (int i = 2; i <= 5; ++i) ASSERT_TRUE(samples.push_back(height_at(0.1 * i, 100)));
  SampleCounts counts;
  EXPECT_EQ(measure_at(samples, moment, counts).height_sigma_m, 0);
  EXPECT_EQ(measure_at({}, moment, counts).height_sigma_m, 0);
  EXPECT_EQ(counts.offered, 0U);
}

TEST(SampleFilterTest, OfMoreSamplesThanFitTheNearestCount) {
  WindowSamples samples;
  // 100 Hz: the first 32 alone would end before the moment, where the height is another.
  for (int i = -60; i <= 60; ++i) add_near(height_at(0.01 * i, 100 + (i < -16 ? 500 : 0)), moment, samples);
  ASSERT_TRUE(samples.full());
  for (const NavigationSample& sample : samples) EXPECT_LE(std::abs(sample.time_ns - moment), 160 * ns_per_ms);
  SampleCounts counts;
  EXPECT_NEAR(measure_at(samples, moment, counts).height_m, 100, 1e-9);
}

TEST(SampleFilterTest, AnAttitudeThatTurnsIsThatOfTheMoment) {
  WindowSamples samples;
  Rng rng(3);
  const Mat3 at_moment = rotation_from_vector(Vec3(3.0, 0.1, 0.2));
  for (int i = -5; i <= 4; ++i) {
    NavigationSample sample = height_at(0.1 * i, 100);
    const Vec3 noise(0.002 * (rng.uniform() - 0.5), 0.002 * (rng.uniform() - 0.5), 0.002 * (rng.uniform() - 0.5));
    RigidTransform reported{.rotation = rotation_from_vector(Vec3(0.5, -0.3, 0.2) * 0.1 * i + noise) * at_moment};
    const Pose pose = pose_from(reported);
    for (int a = 0; a < 4; ++a) sample.q_cam_from_level[a] = pose.q_cam_from_world[a];
    sample.tilt_sigma_rad = 0.001;
    sample.heading_sigma_rad = i == 2 ? 0 : 0.002;
    ASSERT_TRUE(samples.push_back(sample));
  }
  SampleCounts counts;
  const NavigationSample at = measure_at(samples, moment, counts);
  EXPECT_LT(rotation_angle(rotation_from_quaternion(at.q_cam_from_level) * at_moment.transpose()), 0.002);
  EXPECT_GT(at.tilt_sigma_rad, 0);
  EXPECT_EQ(at.heading_sigma_rad, 0) << "one sample does not know north";
}

TEST(SampleFilterTest, PositionsMayCrossTheDateLine) {
  WindowSamples samples;
  for (int i = -3; i <= 3; ++i) {
    NavigationSample sample = height_at(0.1 * i, 100);
    sample.longitude_deg = 180 + 1e-5 * i - (i > 0 ? 360 : 0);
    sample.latitude_deg = 1e-5 * i;
    sample.horizontal_sigma_m = 2;
    ASSERT_TRUE(samples.push_back(sample));
  }
  SampleCounts counts;
  const NavigationSample at = measure_at(samples, moment, counts);
  EXPECT_NEAR(std::fabs(at.longitude_deg), 180, 1e-7);
  EXPECT_NEAR(at.latitude_deg, 0, 1e-7);
  EXPECT_NEAR(at.horizontal_sigma_m, 2, 1e-9) << "errors that change slowly do not average out";
  EXPECT_EQ(at.vertical_sigma_m, 0);
}

}  // namespace
}  // namespace ilp::navigation
