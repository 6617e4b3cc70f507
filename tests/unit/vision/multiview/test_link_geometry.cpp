// The similarity between two cameras against a scene whose answer is known, with noise, wrong matches and another unit.
#include "fsw/vision/multiview/link_geometry.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>
#include <memory>
#include <random>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr double unit_ratio = 3.7;  // units of the newer strip for one of the earlier strip

class LinkGeometryTest : public testing::Test {
 protected:
  LinkGeometryTest() {
    camera_.width = 640;
    camera_.height = 480;
    camera_.fx = camera_.fy = 600;
    camera_.cx = 319.5;
    camera_.cy = 239.5;
  }

  /// Ground with relief of 4 % below two cameras 100 and 80 units high, the second turned by 1.2 rad and tilted.
  void make(int count, double wrong_share, double noise_px, double depth_noise, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::normal_distribution<double> normal(0, 1);
    RigidTransform metric;
    metric.rotation = rotation_from_vector(Vec3(0.05, -0.08, 0)) * rotation_from_vector(Vec3(0, 0, 1.2));
    metric.translation = -(metric.rotation * Vec3(12, -8, 20));
    truth_ = {metric.rotation, unit_ratio * metric.translation, unit_ratio};
    matches_.clear();
    while (static_cast<int>(matches_.size()) < count) {
      const Vec3 a(45 * uniform(random), 35 * uniform(random), 100 + 4 * uniform(random));
      const Vec3 b = truth_ * a;
      Vec2 to = ideal_from_normalised(camera_, Vec2(b.x() / b.z(), b.y() / b.z()));
      if (to.x() < 0 || to.y() < 0 || to.x() > 639 || to.y() > 479) continue;
      const Vec2 from = ideal_from_normalised(camera_, Vec2(a.x() / a.z(), a.y() / a.z()));
      if (0.5 + 0.5 * uniform(random) < wrong_share)
        to = Vec2(320 + 300 * uniform(random), 240 + 220 * uniform(random));
      LinkMatch match;
      match.place_x = from.x() + noise_px * normal(random);
      match.place_y = from.y() + noise_px * normal(random);
      match.place_inverse_depth = (1 + depth_noise * normal(random)) / a.z();
      match.x = to.x() + noise_px * normal(random);
      match.y = to.y() + noise_px * normal(random);
      match.inverse_depth = (1 + depth_noise * normal(random)) / b.z();
      ASSERT_TRUE(matches_.push_back(match));
    }
  }
  Status estimate() { return estimate_link(matches_, camera_, params_, *workspace_, geometry_); }

  CameraModel camera_;
  LinkGeometryParams params_;
  Similarity truth_;
  LinkMatches matches_;
  LinkGeometry geometry_;
  std::unique_ptr<LinkGeometryWorkspace> workspace_ = std::make_unique<LinkGeometryWorkspace>();
};

TEST_F(LinkGeometryTest, ExactMatchesGiveTheExactSimilarity) {
  make(60, 0, 0, 0, 1);
  ASSERT_TRUE(estimate().ok());
  EXPECT_LT(step_between(truth_, geometry_.keyframe_from_place).norm(), 1e-9);
  EXPECT_EQ(geometry_.inliers, 60U);
}

// The square of the error over the stated covariance has a mean of 7 for an honest one.
TEST_F(LinkGeometryTest, StatedErrorsAreHonestBesideWrongMatches) {
  double sum = 0;
  double worst_scale = 0;
  constexpr int trials = 200;
  for (unsigned trial = 0; trial < trials; ++trial) {
    make(100, 0.3, params_.feature_sigma_px, params_.depth_sigma, 100 + trial);
    ASSERT_TRUE(estimate().ok()) << trial;
    const SimilarityStep error = step_between(truth_, geometry_.keyframe_from_place);
    sum += error.dot(geometry_.covariance.inverse() * error);
    worst_scale = std::max(worst_scale, std::fabs(error(6)));
  }
  EXPECT_GT(sum / trials, 4.5);
  EXPECT_LT(sum / trials, 9);
  EXPECT_LT(worst_scale, 0.005);
}

TEST_F(LinkGeometryTest, LargerNoiseThanStatedEnlargesTheStatedError) {
  double sum = 0;
  constexpr int trials = 100;
  for (unsigned trial = 0; trial < trials; ++trial) {
    make(100, 0, 2 * params_.feature_sigma_px, 2 * params_.depth_sigma, 500 + trial);
    ASSERT_TRUE(estimate().ok()) << trial;
    const SimilarityStep error = step_between(truth_, geometry_.keyframe_from_place);
    sum += error.dot(geometry_.covariance.inverse() * error);
  }
  // With the covariance as stated it would be 28. Weights of residuals beyond 1.5 sigma make it a little too small.
  EXPECT_LT(sum / trials, 14);
}

TEST_F(LinkGeometryTest, UnrelatedMatchesGiveNoSimilarity) {
  for (unsigned trial = 0; trial < 20; ++trial) {
    make(60, 1, 0.5, 0.005, 900 + trial);
    EXPECT_FALSE(estimate().ok()) << trial;
  }
}

TEST_F(LinkGeometryTest, WithoutDepthInBothKeyframesThereIsNoScale) {
  make(60, 0, 0.5, 0.005, 3);
  for (LinkMatch& match : matches_) match.inverse_depth = 0;
  EXPECT_EQ(estimate().code, StatusCode::too_few_matches);
  make(60, 0, 0.5, 0.005, 3);
  for (LinkMatch& match : matches_) match.place_inverse_depth = 0;
  EXPECT_EQ(estimate().code, StatusCode::too_few_matches);
}

}  // namespace
}  // namespace ilp
