#include <gtest/gtest.h>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/tools/score/pose_score.hpp"
#include "tests/unit/tools/score/made_up_strip.hpp"

namespace ilp::score {
namespace {

using test::displace;
using test::make_track;

constexpr double degree = 3.14159265358979323846 / 180;

TEST(PoseScore, PosesMovedByASimilarityScoreZero) {
  const auto score = score_poses(make_track(20, 20));
  ASSERT_TRUE(score);
  EXPECT_LT(score->position.max, 1e-9);
  EXPECT_NEAR(score->true_from_strip.scale, 23.7, 1e-9);
  for (const double angle : score->rotation_rad) EXPECT_LT(angle, 1e-6);
  EXPECT_FALSE(score->position_rigid) << "a scale that is nowhere fixed cannot be scored";
}

TEST(PoseScore, OneDisplacedPoseIsFoundAtItsPlace) {
  StripTrack track = make_track(60, 20);
  displace(track.samples[30], Vec3(0, 0, 3));
  const auto score = score_poses(track);
  ASSERT_TRUE(score);
  // The alignment takes up about a sixtieth of it.
  EXPECT_NEAR(score->error[30].z(), 3, 0.1);
  EXPECT_NEAR(score->position.max, 3, 0.1);
  EXPECT_NEAR(score->position.mean, 3.0 / 60, 0.06);
}

TEST(PoseScore, OneTurnedCameraIsFoundAtItsPlace) {
  StripTrack track = make_track(60, 20);
  PoseSample& turned = track.samples[12];
  turned.cam_from_world = rotation_from_vector(Vec3(0, degree, 0)) * turned.cam_from_world;
  const auto score = score_poses(track);
  ASSERT_TRUE(score);
  EXPECT_NEAR(score->rotation_rad[12], degree, 0.03 * degree);
  EXPECT_LT(score->rotation_rad[40], 0.03 * degree);
  EXPECT_LT(score->position.max, 1e-9);
}

TEST(PoseScore, WrongScaleOfAMetricStripIsNotForgiven) {
  StripTrack track = make_track(100, 10);
  track.metric = true;
  // Metric, and 2 % too long.
  for (PoseSample& s : track.samples) s.centre *= 1.02 * 23.7;
  const auto score = score_poses(track);
  ASSERT_TRUE(score && score->position_rigid);
  EXPECT_LT(score->position.max, 1e-9);
  // On a straight track the mean of |0.02 x| about its middle is a quarter of 2 % of the length.
  EXPECT_NEAR(score->position_rigid->mean / score->length(), 0.005, 0.0001);
  EXPECT_NEAR(score->position_rigid->max / score->length(), 0.010, 0.0002);
}

TEST(PoseScore, DistanceIsThePathFlown) {
  StripTrack track = make_track(5, 20);
  const Vec3 corners[] = {{0, 0, 0}, {3, 4, 0}, {3, 4, 12}, {3, 4, 0}, {0, 0, 0}};
  for (std::size_t i = 0; i < 5; ++i) track.samples[i].true_centre = corners[i];
  const std::vector<double> distance = distance_flown(track);
  EXPECT_EQ(distance, (std::vector<double>{0, 5, 17, 29, 34}));
}

TEST(PoseScore, TooFewOrCoincidentPosesAreNotScored) {
  EXPECT_FALSE(score_poses(make_track(0, 20)));
  EXPECT_FALSE(score_poses(make_track(3, 20)));
  EXPECT_FALSE(score_poses(make_track(9, 0)));
  EXPECT_TRUE(score_poses(make_track(4, 20)));
}

}  // namespace
}  // namespace ilp::score
