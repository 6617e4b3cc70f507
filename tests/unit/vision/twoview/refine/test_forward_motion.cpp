// Motion towards what the camera sees, where the matches leave a valley of directions: the estimate says how wide it
// is.
#include "fsw/vision/twoview/refine/forward_motion.hpp"

#include <gtest/gtest.h>

#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "tests/unit/vision/twoview/relative_pose_trials.hpp"

namespace ilp {
namespace {

TwoViewWorkspace workspace;

TEST(ForwardMotion, EpipoleInView) {
  CameraModel camera{640, 480, 700, 700, 319.5, 239.5};
  const auto in_view = [&](const Vec3& translation) {
    return epipole_in_view({Mat3::Identity(), translation.normalized()}, camera, camera);
  };
  EXPECT_TRUE(in_view({0, 0, 1}));
  EXPECT_TRUE(in_view({0, 0, -1}));
  EXPECT_TRUE(in_view({319 / 700.0, 0, 1}));
  EXPECT_FALSE(in_view({322 / 700.0, 0, 1}));
  EXPECT_TRUE(in_view({0, 239 / 700.0, -1}));
  EXPECT_FALSE(in_view({0, 242 / 700.0, -1}));
  EXPECT_FALSE(in_view({1, 0, 0}));
  // Camera b has turned away and looks across the track; camera a still looks along it.
  const Mat3 turn = rotation_from_vector(Vec3(0, 1, 0));
  EXPECT_TRUE(epipole_in_view({turn, turn * Vec3(0, 0, -1)}, camera, camera));
}

/// Over pairs of forward motion: shares of direction errors within one and two estimated sigma.
void shares_within_sigma(int outliers, int noise, double& one, double& two) {
  constexpr int trials = 100;
  one = two = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const test::PoseCase pair = test::make_trial({5, outliers, noise}, 1000 + static_cast<std::uint64_t>(trial));
    RansacParams params{.threshold_px = 0.2 * noise};
    InlierMask inliers;
    TwoViewResult result;
    ASSERT_TRUE(estimate_two_view(pair.pairs, pair.camera, pair.camera, params, workspace, inliers, result).ok());
    const double error = test::direction_error_deg(result.b_from_a, pair.truth) / test::degrees;
    one += error < result.sigma_direction_rad ? 1.0 / trials : 0;
    two += error < 2 * result.sigma_direction_rad ? 1.0 / trials : 0;
  }
}

TEST(ForwardMotion, StatedErrorsCoverTheErrorsMade) {
  for (const int outliers : {30, 50}) {
    for (const int noise : {5, 10}) {
      double one = 0;
      double two = 0;
      shares_within_sigma(outliers, noise, one, two);
      EXPECT_GT(two, 0.85) << outliers << " % at " << 0.1 * noise << " px";
      EXPECT_GT(one, 0.45) << outliers << " % at " << 0.1 * noise << " px";
      EXPECT_LT(one, 0.85) << "not by stating too much: " << outliers << " % at " << 0.1 * noise << " px";
    }
  }
}

TEST(ForwardMotion, TheTwoMotionsOfAPlaneAreNotAveraged) {
  CameraModel camera{640, 480, 600, 600, 319.5, 239.5};
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Rng rng(seed);
    const auto between = [&](double a, double b) { return a + (b - a) * rng.uniform(); };
    // An oblique climb over level ground at a distance of one, seen with a slight swing.
    const Mat3 tilt = rotation_from_vector(Vec3(between(-0.15, 0.15), between(-0.15, 0.15), 0));
    const RigidTransform b_from_a{rotation_from_vector(Vec3(between(-0.1, 0.1), between(-0.1, 0.1), 0.1)),
                                  Vec3(between(0.1, 0.2), between(-0.05, 0.05), 0.18)};
    PointPairs pairs;
    while (pairs.size() < 90) {
      const Vec3 ray = tilt.transpose() * Vec3(between(-0.5, 0.5), between(-0.4, 0.4), 1);
      const Vec3 a = tilt * (ray / ray.z());
      const Vec3 b = b_from_a * a;
      const auto pixel = [&](double v, double focal, double centre) {
        return v * focal + centre + 0.2 * std::sqrt(3.0) * between(-1, 1);
      };
      const PointPair pair{pixel(a.x() / a.z(), 600, 319.5), pixel(a.y() / a.z(), 600, 239.5),
                           pixel(b.x() / b.z(), 600, 319.5), pixel(b.y() / b.z(), 600, 239.5), 1};
      ASSERT_TRUE(pairs.push_back(pair));
    }
    InlierMask inliers;
    TwoViewResult result;
    ASSERT_TRUE(estimate_two_view(pairs, camera, camera, {}, workspace, inliers, result).ok());
    EXPECT_GE(result.inliers, 86U) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ilp
