#include "sim/score/consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "made_up_strip.hpp"

namespace ilp::score {
namespace {

using test::make_track;
using test::strip_from_true;

constexpr double sigmas[] = {0.004, 0.002, 0.007};

// Each position is off from the one before by normal noise, as a flight would find it that hangs every camera on those
// before it; the stated sigmas are the truth's times `stated`. The cameras of the last window are stated relative to
// the camera before it.
StripTrack random_walk(std::size_t count, double stated, std::mt19937& random) {
  StripTrack track = make_track(count, 20);
  std::normal_distribution<double> normal;
  Vec3 walk = Vec3::Zero();
  const std::size_t last_window = count - track.window_keyframes;
  for (std::size_t i = 0; i < count; ++i) {
    PoseSample& s = track.samples[i];
    const double steps = i < last_window ? 1 : static_cast<double>(i - last_window + 1);
    for (int k = 0; k < 3; ++k) {
      walk[k] += sigmas[k] * normal(random);
      s.sigma[k] = stated * sigmas[k] * std::sqrt(steps);
    }
    s.centre += walk;
  }
  return track;
}

SigmaScore many_strips(double stated) {
  std::mt19937 random(7);
  SigmaScore all;
  for (int strip = 0; strip < 80; ++strip) all.add(score_sigmas(random_walk(30, stated, random)));
  return all;
}

// The local scale is itself measured on noisy steps: the errors are a little larger than the noise put in.
TEST(Consistency, HonestSigmasAreFoundHonest) {
  const SigmaScore score = many_strips(1);
  EXPECT_EQ(score.components, 80U * 28 * 3);
  EXPECT_NEAR(score.share_within_one(), 0.683, 0.035);
  EXPECT_NEAR(score.share_within_two(), 0.954, 0.03);
  EXPECT_GT(score.normalised_error_squared(), 0.9);
  EXPECT_LT(score.normalised_error_squared(), 1.3);
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

TEST(Consistency, WhatHasAccumulatedBeforeIsNotCounted) {
  StripTrack track = make_track(30, 20);
  for (PoseSample& s : track.samples) s.sigma = Vec3(1e-3, 1e-3, 1e-3);
  // From the tenth on, everything is off by the same large amount: one keyframe is wrong against those before it.
  for (std::size_t i = 10; i < 30; ++i) track.samples[i].centre += Vec3(0, 0, 0.05);
  const SigmaScore score = score_sigmas(track);
  ASSERT_TRUE(score.error.contains(11) && score.error.contains(9) && score.error.contains(20));
  EXPECT_NEAR(score.error.at(11).z(), 0.05, 1e-6);
  EXPECT_LT(score.error.at(9).norm(), 1e-9);
  EXPECT_LT(score.error.at(20).norm(), 1e-9);
}

TEST(Consistency, StripsCutShortHaveNoLastWindow) {
  StripTrack track = make_track(12, 20);
  for (PoseSample& s : track.samples) s.sigma = Vec3(1e-3, 1e-3, 1e-3);
  for (std::size_t i = 8; i < 12; ++i) track.samples[i].centre += Vec3(0, 0, 0.05);
  // Adjusted together in the last window, all four are off from the cameras before it.
  EXPECT_NEAR(score_sigmas(track).error.at(12).z(), 0.05, 1e-6);
  // Each became final alone: the last is off from the one before it only by the turn and scale of its predecessors.
  track.ended = false;
  EXPECT_NEAR(score_sigmas(track).error.at(9).z(), 0.05, 1e-6);
  EXPECT_LT(score_sigmas(track).error.at(12).norm(), 0.025);
}

TEST(Consistency, CamerasWithoutSigmaOrWithoutPredecessorsAreLeftOut) {
  StripTrack track = make_track(20, 20);
  EXPECT_EQ(score_sigmas(track).components, 0U) << "no sigma is stated";
  EXPECT_TRUE(std::isnan(score_sigmas(track).normalised_error_squared()));
  for (PoseSample& s : track.samples) s.sigma = Vec3(1, 1, 1);
  EXPECT_EQ(score_sigmas(track).components, 3U * 18);
  track.samples.resize(7);
  EXPECT_EQ(score_sigmas(track).components, 0U) << "the whole strip is the first window and one camera";
}

}  // namespace
}  // namespace ilp::score
