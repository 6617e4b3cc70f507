#include "sim/tools/score/drift.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "tests/unit/tools/score/made_up_strip.hpp"

namespace ilp::score {
namespace {

using test::displace;
using test::make_track;

// Each step of the estimate is `factor(share of the strip)` times too long.
template <typename Factor>
void stretch_steps(StripTrack& track, Factor factor) {
  Vec3 error = Vec3::Zero();
  const auto steps = static_cast<double>(track.samples.size() - 1);
  for (std::size_t i = 1; i < track.samples.size(); ++i) {
    const double middle = (static_cast<double>(i) - 0.5) / steps;
    error += (factor(middle) - 1) * (track.samples[i].true_centre - track.samples[i - 1].true_centre);
    displace(track.samples[i], error);
  }
}

// z is moved by `sagitta` in the middle against both ends.
void bow_up(StripTrack& track, double sagitta) {
  const std::vector<double> distance = distance_flown(track);
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const double u = 2 * distance[i] / distance.back() - 1;
    displace(track.samples[i], Vec3(0, 0, sagitta * (1 - u * u)));
  }
}

TEST(Drift, ExactPosesDoNotDrift) {
  const StripTrack track = make_track(24, 20);
  const auto drift = measure_drift(track);
  const auto scale = measure_scale_drift(track);
  const auto bow = measure_bow(track);
  ASSERT_TRUE(drift && scale && bow);
  EXPECT_LT(drift->percent, 1e-9);
  EXPECT_NEAR(scale->percent, 0, 1e-9);
  EXPECT_NEAR(bow->percent, 0, 1e-9);
  for (const double s : scale->local_scale) EXPECT_NEAR(s, 1, 1e-9);
}

TEST(Drift, ErrorThatGrowsAfterTheBeginIsSeenAtTheEnd) {
  StripTrack track = make_track(24, 20);
  const double length = distance_flown(track).back();
  // To the side, 0 over the first quarter of the keyframes, then in steps up to 2 % of the distance.
  for (std::size_t i = 6; i < 24; ++i)
    displace(track.samples[i], Vec3(0, 0.02 * length * (static_cast<double>(i) - 5) / 18, 0));
  const auto drift = measure_drift(track);
  ASSERT_TRUE(drift);
  EXPECT_EQ(drift->aligned_samples, 6U);
  EXPECT_NEAR(drift->percent, 2, 1e-6);
  EXPECT_NEAR(drift->end_error, 0.02 * length, 1e-6);
  EXPECT_LT(drift->error[5].norm(), 1e-9);
  // Alignment over the whole strip hides most of it.
  EXPECT_LT(100 * score_poses(track)->position.max / length, 1);
}

TEST(Drift, ScaleThatGrowsIsRecoveredWithItsSign) {
  for (const double change : {0.04, -0.04}) {
    StripTrack track = make_track(30, 20);
    stretch_steps(track, [change](double middle) { return std::pow(1 + change, middle); });
    const auto scale = measure_scale_drift(track);
    ASSERT_TRUE(scale);
    EXPECT_NEAR(scale->percent, 100 * change, 0.02);
    EXPECT_NEAR(scale->local_scale.back() / scale->local_scale.front(), 1 + change, 0.005);
  }
}

TEST(Drift, AWrongScaleOfTheWholeStripIsNoScaleDrift) {
  StripTrack track = make_track(30, 20);
  for (PoseSample& s : track.samples) s.centre *= 1.3;
  EXPECT_NEAR(measure_scale_drift(track)->percent, 0, 1e-9);
}

TEST(Drift, BowIsRecoveredWithItsSign) {
  for (const double sagitta : {3.0, -3.0}) {
    StripTrack track = make_track(40, 10);
    bow_up(track, sagitta);
    const auto bow = measure_bow(track);
    ASSERT_TRUE(bow);
    // 3 over a flying height of 100.
    EXPECT_NEAR(bow->percent, sagitta, 0.05);
    EXPECT_NEAR(bow->sagitta, sagitta, 0.05);
    EXPECT_GT(track_axes(track).up.z(), 0.99);
    EXPECT_GT(track_axes(track).forward.x(), 0.99);
  }
}

TEST(Drift, HeightsTakeAwayABowOfTheTrackAndNotOneThatTheGroundShares) {
  for (const bool ground_shares_it : {false, true}) {
    StripTrack track = make_track(40, 10);
    bow_up(track, 3);
    const host::Similarity3 strip = test::strip_from_true();
    for (PoseSample& s : track.samples) {
      s.measured_height_m = 100;
      const double too_high = (strip.rotation.transpose() * (s.centre - strip * s.true_centre)).z() / strip.scale;
      s.ground_distance = strip.scale * (100 + (ground_shares_it ? 0 : too_high));
    }
    const auto left = bow_after_heights_percent(track);
    ASSERT_TRUE(left);
    EXPECT_NEAR(*left, ground_shares_it ? 3 : 0, 0.1);
  }
  EXPECT_FALSE(bow_after_heights_percent(make_track(40, 10)));
}

TEST(Drift, BowToTheSideIsNoBowOfTheHeights) {
  StripTrack track = make_track(40, 10);
  const std::vector<double> distance = distance_flown(track);
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const double u = 2 * distance[i] / distance.back() - 1;
    displace(track.samples[i], Vec3(0, 5 * (1 - u * u), 0));
  }
  EXPECT_NEAR(measure_bow(track)->percent, 0, 0.3);
}

TEST(Drift, BowDoesNotDependOnTheAxesOfTheTruth) {
  StripTrack track = make_track(40, 10);
  bow_up(track, 3);
  const double upright = measure_bow(track)->percent;
  const Mat3 turn = rotation_from_vector(Vec3(1.1, 0.4, -2));
  for (PoseSample& s : track.samples) {
    s.true_centre = turn * s.true_centre;
    s.true_cam_from_world = s.true_cam_from_world * turn.transpose();
  }
  EXPECT_NEAR(measure_bow(track)->percent, upright, 1e-9);
}

TEST(Drift, ShortStripsAreNotMeasured) {
  EXPECT_FALSE(measure_drift(make_track(5, 20)));
  EXPECT_FALSE(measure_scale_drift(make_track(5, 20)));
  EXPECT_FALSE(measure_bow(make_track(5, 20)));
  EXPECT_FALSE(measure_drift(make_track(0, 20)));
  // Hovering: no distance to speak of.
  EXPECT_FALSE(measure_drift(make_track(20, 0)));
  EXPECT_FALSE(measure_scale_drift(make_track(20, 0)));
  EXPECT_FALSE(measure_bow(make_track(20, 0)));
  StripTrack unknown_height = make_track(20, 20);
  unknown_height.flying_height = 0;
  EXPECT_FALSE(measure_bow(unknown_height));
}

}  // namespace
}  // namespace ilp::score
