#include "sim/tools/score/pose_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "tests/unit/tools/score/made_up_strip.hpp"

namespace ilp::score {
namespace {

using test::make_track;
using test::strip_from_true;

constexpr double sigmas[] = {0.004, 0.002, 0.007};

// Each position is off from the previous one by normal noise, except the first two, which define the gauge; the stated
// sigmas are the truth's times `stated`.
StripTrack random_walk(std::size_t count, double stated, std::mt19937& random) {
  StripTrack track = make_track(count, 20);
  std::normal_distribution<double> normal;
  Vec3 walk = Vec3::Zero();
  for (std::size_t i = 2; i < count; ++i) {
    PoseSample& s = track.samples[i];
    for (int k = 0; k < 3; ++k) {
      walk[k] += sigmas[k] * normal(random);
      s.sigma[k] = stated * sigmas[k] * std::sqrt(static_cast<double>(i - 1));
    }
    s.centre += walk;
  }
  return track;
}

SigmaScore many_strips(double stated) {
  std::mt19937 random(7);
  SigmaScore all;
  for (int strip = 0; strip < 400; ++strip) all.add(score_sigmas(random_walk(30, stated, random)));
  return all;
}

TEST(Consistency, HonestSigmasAreFoundHonest) {
  const SigmaScore score = many_strips(1);
  EXPECT_EQ(score.components, 400U * 28 * 3);
  EXPECT_NEAR(score.share_within_one(), 0.683, 0.035);
  EXPECT_NEAR(score.share_within_two(), 0.954, 0.03);
  EXPECT_NEAR(score.normalised_error_squared(), 1, 0.1);
}

TEST(Consistency, SigmasStatedTooSmallAreFound) {
  const SigmaScore score = many_strips(0.5);
  // A normal variable is within half a sigma in 38 % of all cases.
  EXPECT_NEAR(score.share_within_one(), 0.383, 0.035);
  EXPECT_NEAR(score.share_within_two(), 0.683, 0.035);
  EXPECT_NEAR(score.normalised_error_squared(), 4 * many_strips(1).normalised_error_squared(), 1e-9);
}

TEST(Consistency, SigmasStatedTooLargeAreFound) {
  const SigmaScore score = many_strips(3);
  EXPECT_GT(score.share_within_one(), 0.985);
  EXPECT_LT(score.normalised_error_squared(), 0.15);
}

TEST(Consistency, ErrorsAreThoseInTheGaugeOfTheFirstPair) {
  StripTrack track = make_track(12, 20);
  for (PoseSample& s : track.samples) s.sigma = Vec3(1e-3, 1e-3, 1e-3);
  for (const auto& [id, error] : score_sigmas(track).error) EXPECT_LT(error.norm(), 1e-9) << id;
  track.samples[7].centre += Vec3(0.01, 0, 0.05);
  EXPECT_NEAR((score_sigmas(track).error.at(8) - Vec3(0.01, 0, 0.05)).norm(), 0, 1e-9);
  EXPECT_LT(score_sigmas(track).error.at(9).norm(), 1e-9) << "no fit spreads it over the others";
  // A first camera that is turned by a milliradian leaves every other one off by that much of its distance.
  const double distance = (track.samples[11].centre - track.samples[0].centre).norm();
  track.samples[0].cam_from_world = rotation_from_vector(Vec3(0, 1e-3, 0)) * track.samples[0].cam_from_world;
  EXPECT_NEAR(score_sigmas(track).error.at(12).norm(), 1e-3 * distance, 2e-4 * distance);
}

TEST(Consistency, CamerasWithoutSigmaAndTheFirstPairAreLeftOut) {
  StripTrack track = make_track(20, 20);
  EXPECT_EQ(score_sigmas(track).components, 0U) << "no sigma is stated";
  EXPECT_TRUE(std::isnan(score_sigmas(track).normalised_error_squared()));
  for (PoseSample& s : track.samples) s.sigma = Vec3(1, 1, 1);
  EXPECT_EQ(score_sigmas(track).components, 3U * 18);
  track.from_the_start = false;
  EXPECT_EQ(score_sigmas(track).components, 0U) << "the pair that defines the gauge is not among the samples";
  track.from_the_start = true;
  track.samples.resize(2);
  EXPECT_EQ(score_sigmas(track).components, 0U);
}

}  // namespace
}  // namespace ilp::score
