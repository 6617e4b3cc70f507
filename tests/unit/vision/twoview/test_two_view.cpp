// Relative pose of made-up pairs with known motion; what it says of pairs that cannot tell; and what it does with
// nonsense.
#include "fsw/vision/twoview/two_view.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

using test::Motion;
using test::Scene;
using test::SceneOptions;

TwoViewWorkspace workspace;
InlierMask inliers;

TwoViewResult estimate(const Scene& scene, const RansacParams& params = {}) {
  TwoViewResult result;
  EXPECT_TRUE(estimate_two_view(scene.pairs, scene.camera_a, scene.camera_b, params, workspace, inliers, result).ok());
  EXPECT_EQ(inliers.size(), scene.pairs.size());
  return result;
}

struct Expectation {
  SceneOptions options;
  TwoViewVerdict verdict;
  double rotation_deg, direction_deg;
};

void expect_pose(const Expectation& expected) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SceneOptions options = expected.options;
    options.seed = seed;
    options.noise_px = 0.5;
    const Scene scene = test::make_scene(options);
    const TwoViewResult result = estimate(scene);
    EXPECT_EQ(result.verdict, expected.verdict) << name_of(result.verdict) << ", seed " << seed;
    EXPECT_LT(test::rotation_error_deg(result.b_from_a, scene.b_from_a), expected.rotation_deg) << seed;
    EXPECT_LT(test::direction_error_deg(result.b_from_a, scene.b_from_a), expected.direction_deg) << seed;
    EXPECT_NEAR(result.b_from_a.translation.norm(), 1, 1e-12);
    EXPECT_NEAR(result.rms_px, 0.45, 0.1);
    int missed = 0;
    int false_alarms = 0;
    for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
      missed += scene.inlier[i] && inliers[i] == 0 ? 1 : 0;
      false_alarms += !scene.inlier[i] && inliers[i] != 0 ? 1 : 0;
    }
    EXPECT_LT(missed, 0.12 * options.matches);  // 5 % lie beyond two sigma
    EXPECT_LE(false_alarms, 6);
  }
}

TEST(TwoView, GeneralScene) {
  SceneOptions options{.outlier_share = 0.4};
  expect_pose({options, TwoViewVerdict::ok, 0.4, 1.5});
}

TEST(TwoView, Plane) {
  SceneOptions options{.relief = 0, .outlier_share = 0.4};
  expect_pose({options, TwoViewVerdict::planar, 0.8, 4});
}

TEST(TwoView, StraightTrackOverPlane) {
  SceneOptions options{.motion = Motion::line, .relief = 0, .outlier_share = 0.4};
  expect_pose({options, TwoViewVerdict::planar, 0.8, 4});
}

TEST(TwoView, ForwardMotion) {
  SceneOptions options{.motion = Motion::forward, .outlier_share = 0.3};
  expect_pose({options, TwoViewVerdict::ok, 0.8, 4});
}

TEST(TwoView, ExactDataGiveTheExactPose) {
  for (const double relief : {0.0, 0.2}) {
    SceneOptions options{.relief = relief};
    const Scene scene = test::make_scene(options);
    const TwoViewResult result = estimate(scene);
    EXPECT_LT(test::rotation_error_deg(result.b_from_a, scene.b_from_a), 1e-5);
    EXPECT_LT(test::direction_error_deg(result.b_from_a, scene.b_from_a), 1e-4);
    EXPECT_EQ(result.inliers, 300U);
  }
}

TEST(TwoView, RotationAloneHasTooLittleParallax) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SceneOptions options{.motion = Motion::rotation_only, .outlier_share = 0.3, .noise_px = 0.5, .seed = seed};
    const Scene scene = test::make_scene(options);
    const TwoViewResult result = estimate(scene);
    EXPECT_EQ(result.verdict, TwoViewVerdict::too_little_parallax) << name_of(result.verdict);
    EXPECT_LT(test::rotation_error_deg(result.b_from_a, scene.b_from_a), 0.3);
  }
}

TEST(TwoView, IdenticalImagesHaveTooLittleParallax) {
  SceneOptions options;
  Scene scene = test::make_scene(options);
  for (PointPair& p : scene.pairs) {
    p.xb = p.xa;
    p.yb = p.ya;
  }
  scene.camera_b = scene.camera_a;
  EXPECT_EQ(estimate(scene).verdict, TwoViewVerdict::too_little_parallax);
}

TEST(TwoView, ParallaxIsMeasured) {
  SceneOptions options{.motion = Motion::line, .relief = 0};
  const Scene scene = test::make_scene(options);
  // Pure translation by 0.18 altitudes: every point moves by 0.18 fx of camera b.
  EXPECT_NEAR(estimate(scene).median_parallax_px, 0.18 * scene.camera_b.fx, 0.5);
}

TEST(TwoView, PointsOnALineLeaveThePoseOpen) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SceneOptions options{.relief = 0, .on_a_line = true, .noise_px = seed % 2 == 0 ? 0.5 : 0, .seed = seed};
    const TwoViewResult result = estimate(test::make_scene(options));
    EXPECT_NE(result.verdict, TwoViewVerdict::ok);
    EXPECT_NE(result.verdict, TwoViewVerdict::planar);
  }
}

TEST(TwoView, FewMatchesAreAVerdict) {
  SceneOptions options;
  for (const int matches : {0, 1, 4, 5, 6, 12}) {
    options.matches = matches;
    const TwoViewResult result = estimate(test::make_scene(options));
    EXPECT_EQ(result.verdict, TwoViewVerdict::too_few_inliers) << matches;
  }
}

TEST(TwoView, NoiseAloneIsAVerdict) {
  SceneOptions options{.matches = 200, .outlier_share = 1};
  RansacParams params{.min_inliers = 40};
  EXPECT_EQ(estimate(test::make_scene(options), params).verdict, TwoViewVerdict::too_few_inliers);
}

TEST(TwoView, NonFiniteMatchesAreOutliers) {
  SceneOptions options{.noise_px = 0.3};
  Scene scene = test::make_scene(options);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 60; ++i) {
    double* const coordinates[4] = {&scene.pairs[i].xa, &scene.pairs[i].ya, &scene.pairs[i].xb, &scene.pairs[i].yb};
    *coordinates[i % 4] = i % 3 == 0 ? nan : (i % 3 == 1 ? infinity : 1e300);
    scene.pairs[i].quality = std::numeric_limits<float>::quiet_NaN();
  }
  const TwoViewResult result = estimate(scene);
  EXPECT_EQ(result.verdict, TwoViewVerdict::ok);
  EXPECT_LT(test::direction_error_deg(result.b_from_a, scene.b_from_a), 1);
  for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(inliers[i], 0);

  for (PointPair& p : scene.pairs) p.xa = nan;
  EXPECT_EQ(estimate(scene).verdict, TwoViewVerdict::too_few_inliers);
}

TEST(TwoView, CoincidentMatchesAreAVerdict) {
  Scene scene = test::make_scene({});
  for (PointPair& p : scene.pairs) p = scene.pairs[0];
  const TwoViewResult result = estimate(scene);
  EXPECT_NE(result.verdict, TwoViewVerdict::ok);
  EXPECT_NE(result.verdict, TwoViewVerdict::planar);
}

TEST(TwoView, SameSeedSameBytes) {
  SceneOptions options{.outlier_share = 0.5, .noise_px = 0.7};
  const Scene scene = test::make_scene(options);
  const TwoViewResult first = estimate(scene);
  const InlierMask first_inliers = inliers;
  // What an earlier call left in the workspace must not show.
  options.seed = 9;
  options.matches = 400;
  estimate(test::make_scene(options));
  const TwoViewResult second = estimate(scene);
  EXPECT_EQ(std::memcmp(first.b_from_a.rotation.data(), second.b_from_a.rotation.data(), 9 * sizeof(double)), 0);
  EXPECT_EQ(std::memcmp(first.b_from_a.translation.data(), second.b_from_a.translation.data(), 3 * sizeof(double)), 0);
  EXPECT_EQ(first.gric_e, second.gric_e);
  EXPECT_EQ(first.gric_h, second.gric_h);
  ASSERT_EQ(first_inliers.size(), inliers.size());
  EXPECT_EQ(std::memcmp(first_inliers.data(), inliers.data(), inliers.size()), 0);
}

TEST(TwoView, QualityOrdersTheSamples) {
  // With 80 % outliers, 150 uniform samples of five hardly ever hold an outlier-free one; the best by quality do.
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SceneOptions options{
        .matches = 500, .outlier_share = 0.8, .noise_px = 0.3, .informative_quality = true, .seed = seed};
    const Scene scene = test::make_scene(options);
    RansacParams params{.max_trials = 150};
    const TwoViewResult result = estimate(scene, params);
    if (test::direction_error_deg(result.b_from_a, scene.b_from_a) < 3) ++found;
  }
  EXPECT_GE(found, 9);
}

TEST(TwoView, SigmasPredictTheErrors) {
  // Noise drawn again and again: the errors must be of the size that the normal equations announce.
  double rotation2 = 0;
  double direction2 = 0;
  double sigma_rotation2 = 0;
  double sigma_direction2 = 0;
  constexpr int trials = 60;
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    SceneOptions options{.noise_px = 0.5, .seed = 100 + trial};
    const Scene scene = test::make_scene(options);
    const TwoViewResult result = estimate(scene);
    const double rotation = test::rotation_error_deg(result.b_from_a, scene.b_from_a) / test::degrees;
    const double direction = test::direction_error_deg(result.b_from_a, scene.b_from_a) / test::degrees;
    rotation2 += rotation * rotation;
    direction2 += direction * direction;
    sigma_rotation2 += result.sigma_rotation_rad * result.sigma_rotation_rad;
    sigma_direction2 += result.sigma_direction_rad * result.sigma_direction_rad;
  }
  // The sum over all axes lies between one and three (two) times the worst axis.
  EXPECT_GT(rotation2, 0.6 * sigma_rotation2);
  EXPECT_LT(rotation2, 3 * sigma_rotation2);
  EXPECT_GT(direction2, 0.6 * sigma_direction2);
  EXPECT_LT(direction2, 2.5 * sigma_direction2);
}

TEST(TwoView, OneMatchByChanceDoesNotTurnAPlane) {
  // A false match on its epipolar line but at a third of the altitude has great leverage on a plane.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SceneOptions options{.relief = 0.005, .noise_px = 0.5, .seed = seed};
    Scene scene = test::make_scene(options);
    const TwoViewResult clean = estimate(scene);
    const Vec3 near = scene.points[0] / 3;
    const Vec3 seen = scene.b_from_a * near;
    scene.pairs[0].xb = scene.camera_b.fx * seen.x() / seen.z() + scene.camera_b.cx + 1.4;
    scene.pairs[0].yb = scene.camera_b.fy * seen.y() / seen.z() + scene.camera_b.cy + 1.4;
    const TwoViewResult disturbed = estimate(scene);
    EXPECT_LT(test::direction_error_deg(disturbed.b_from_a, clean.b_from_a), 0.7) << seed;
    EXPECT_EQ(inliers[0], 0);
  }
}

TEST(TwoView, RocksOnAPlaneStayInliers) {
  // Ten per cent of the points stand out of the plane by a tenth of the altitude: relief, not chance.
  SceneOptions options{.relief = 0, .noise_px = 0.3};
  Scene scene = test::make_scene(options);
  for (std::size_t i = 0; i < 30; ++i) {
    const Vec3 rock = 0.9 * scene.points[i];
    const Vec3 seen = scene.b_from_a * rock;
    scene.pairs[i].xb = scene.camera_b.fx * seen.x() / seen.z() + scene.camera_b.cx;
    scene.pairs[i].yb = scene.camera_b.fy * seen.y() / seen.z() + scene.camera_b.cy;
  }
  const TwoViewResult result = estimate(scene);
  EXPECT_LT(test::direction_error_deg(result.b_from_a, scene.b_from_a), 1);
  int kept = 0;
  for (std::size_t i = 0; i < 30; ++i) kept += inliers[i];
  EXPECT_GE(kept, 28);
}

TEST(TwoView, ParametersOutOfRangeAreRefused) {
  const Scene scene = test::make_scene({});
  TwoViewResult result;
  const auto refused = [&](const RansacParams& params) {
    return estimate_two_view(scene.pairs, scene.camera_a, scene.camera_b, params, workspace, inliers, result)
        .is(StatusCode::invalid_argument);
  };
  RansacParams params{.threshold_px = std::numeric_limits<double>::quiet_NaN()};
  EXPECT_TRUE(refused(params));
  params = {};
  params.confidence = 1;
  EXPECT_TRUE(refused(params));
  params = {};
  params.max_trials = limits::max_ransac_trials + 1;
  EXPECT_TRUE(refused(params));
  CameraModel camera = scene.camera_a;
  camera.fx = -1;
  EXPECT_FALSE(estimate_two_view(scene.pairs, camera, scene.camera_b, {}, workspace, inliers, result).ok());
}

}  // namespace
}  // namespace ilp
