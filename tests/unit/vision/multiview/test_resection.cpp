#include "fsw/vision/multiview/resection.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "fsw/vision/multiview/p3p.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp {
namespace {

double angle_between(const Mat3& a, const Mat3& b) {
  return rotation_angle(a * b.transpose());
}

TEST(P3p, FindsTheTruePoseAmongItsSolutions) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int found = 0;
  constexpr int trials = 20000;
  for (int trial = 0; trial < trials; ++trial) {
    RigidTransform truth;
    truth.rotation = rotation_from_vector(3 * Vec3(uniform(random), uniform(random), uniform(random)));
    truth.translation = Vec3(uniform(random), uniform(random), uniform(random));
    Vec3 bearing[3];
    Vec3 point[3];
    for (int i = 0; i < 3; ++i) {
      const double depth = 3 + 2 * uniform(random);
      const Vec3 x(0.5 * depth * uniform(random), 0.5 * depth * uniform(random), depth);
      bearing[i] = x.normalized();
      point[i] = inverse(truth) * x;
    }
    RigidTransform solutions[max_p3p_solutions];
    const int count = solve_p3p(bearing, point, solutions);
    double best = 1;
    for (int s = 0; s < count; ++s) {
      best = std::min(best, angle_between(solutions[s].rotation, truth.rotation) +
                                (solutions[s].translation - truth.translation).norm());
      // Whatever is called a solution must be one: a rotation that maps the points onto the rays.
      EXPECT_NEAR(solutions[s].rotation.determinant(), 1, 1e-3);
    }
    found += best < 1e-6 ? 1 : 0;
  }
  EXPECT_GT(found, trials * 0.999);
}

// Distances are poor there in some views; what is called a rotation must be one all the same, for a refinement keeps it
// as it is.
TEST(P3p, StraightDownOverAPlaneSolutionsAreRotations) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, 0.0002);
  double worst = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Vec3 bearing[3];
    Vec3 point[3];
    for (int i = 0; i < 3; ++i) {
      const double x = 0.55 * uniform(random);
      const double y = 0.4 * uniform(random);
      bearing[i] = Vec3(x + noise(random), y + noise(random), 1).normalized();
      point[i] = Vec3(23 + 4.5 * x, -4.5 * y, -4.5);
    }
    RigidTransform solutions[max_p3p_solutions];
    const int count = solve_p3p(bearing, point, solutions);
    for (int s = 0; s < count; ++s) {
      const Mat3& r = solutions[s].rotation;
      worst = std::max(worst, (r * r.transpose() - Mat3::Identity()).norm());
    }
  }
  EXPECT_LT(worst, 1e-12);
}

TEST(P3p, SurvivesDegenerateTriples) {
  RigidTransform solutions[max_p3p_solutions];
  const Vec3 bearing[3] = {Vec3(0, 0, 1), Vec3(0.1, 0, 1).normalized(), Vec3(0.2, 0, 1).normalized()};
  const Vec3 collinear[3] = {Vec3(0, 0, 5), Vec3(0.5, 0, 5), Vec3(1, 0, 5)};
  EXPECT_EQ(solve_p3p(bearing, collinear, solutions), 0);
  const Vec3 equal[3] = {Vec3(0, 0, 5), Vec3(0, 0, 5), Vec3(1, 1, 5)};
  EXPECT_EQ(solve_p3p(bearing, equal, solutions), 0);
  const Vec3 same[3] = {bearing[0], bearing[0], bearing[0]};
  const Vec3 triangle[3] = {Vec3(0, 0, 5), Vec3(1, 0, 5), Vec3(0, 1, 5)};
  for (int s = 0, n = solve_p3p(same, triangle, solutions); s < n; ++s) EXPECT_TRUE(solutions[s].rotation.allFinite());
}

struct Scene {
  CameraModel camera{640, 480, 700, 710, 318, 243};
  RigidTransform truth;
  PointViews views;
};

/// Ground of the given relief (0 = plane) seen from height 10.
void make_scene(Scene& scene, int count, double relief, double noise_px, double outliers, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, 1);
  scene.truth = test::looking_down(Vec3(3, -2, 10), Vec3(0.08, -0.05, 0.7));
  scene.views.clear();
  for (int i = 0; i < count; ++i) {
    const Vec2 pixel(320 + 319 * uniform(random), 240 + 239 * uniform(random));
    const Vec3 ray = scene.truth.rotation.transpose() * Vec3((pixel.x() - scene.camera.cx) / scene.camera.fx,
                                                             (pixel.y() - scene.camera.cy) / scene.camera.fy, 1);
    const double height = relief * uniform(random);
    const Vec3 centre = inverse(scene.truth).translation;
    const Vec3 x = centre + ray * ((height - centre.z()) / ray.z());
    PointView view{{x.x(), x.y(), x.z()}, pixel.x() + noise_px * noise(random), pixel.y() + noise_px * noise(random)};
    if (i < outliers * count) {
      view.x = 320 + 319 * uniform(random);
      view.y = 240 + 239 * uniform(random);
    }
    (void)scene.views.push_back(view);
  }
}

Scene scene;
ViewMask inliers;

TEST(Resection, RecoversThePoseThroughOutliers) {
  for (const double relief : {0.0, 0.1, 1.0}) {
    for (const double outliers : {0.0, 0.3, 0.6}) {
      for (unsigned seed = 1; seed <= 5; ++seed) {
        make_scene(scene, 200, relief, 0.3, outliers, seed);
        ResectionResult result;
        ASSERT_TRUE(resect(scene.views, scene.camera, {.seed = seed}, inliers, result).ok());
        const double position_error =
            (inverse(result.cam_from_world).translation - inverse(scene.truth).translation).norm();
        EXPECT_LT(position_error, 0.03) << "relief " << relief << ", outliers " << outliers;  // 0.3 % of the height
        EXPECT_LT(angle_between(result.cam_from_world.rotation, scene.truth.rotation), 0.003);
        EXPECT_GE(result.inliers, static_cast<std::uint32_t>(200 * (1 - outliers)) - 1);
        EXPECT_NEAR(result.rms_px, 0.3, 0.1);
        for (std::size_t i = static_cast<std::size_t>(200 * outliers); i < 200; ++i) EXPECT_EQ(inliers[i], 1);
      }
    }
  }
}

TEST(Resection, HuberBoundLimitsWhatGrossErrorsDo) {
  make_scene(scene, 200, 0.5, 0.2, 0, 3);
  for (std::size_t i = 0; i < scene.views.size(); i += 5)
    scene.views[i].x += 4;  // inside the threshold, all to one side
  const auto error = [](double robust_px) {
    ResectionResult result;
    EXPECT_TRUE(resect(scene.views, scene.camera, {.threshold_px = 6, .robust_px = robust_px}, inliers, result).ok());
    EXPECT_EQ(result.inliers, 200U);
    return (inverse(result.cam_from_world).translation - inverse(scene.truth).translation).norm();
  };
  EXPECT_LT(error(0.3), 0.5 * error(0));
}

TEST(Resection, IsExactWithoutNoise) {
  make_scene(scene, 50, 0.5, 0, 0, 3);
  ResectionResult result;
  ASSERT_TRUE(resect(scene.views, scene.camera, {}, inliers, result).ok());
  EXPECT_LT((result.cam_from_world.translation - scene.truth.translation).norm(), 1e-9);
  EXPECT_LT(result.trials, 5U);
}

TEST(Resection, StraightDownOverAPlaneEverySampleEndsInThePose) {
  scene = {};
  scene.camera = {640, 480, 550, 550, 319.5, 239.5};
  scene.truth.rotation = Vec3(1, -1, -1).asDiagonal();
  scene.truth.translation = Vec3(-23, 0, 0);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, 0.07);
  for (int i = 0; i < 700; ++i) {
    const Vec3 x(23 + 2.5 * uniform(random), 1.9 * uniform(random), -4.45 + 0.05 * uniform(random));
    const Vec3 p = scene.truth * x;
    (void)scene.views.push_back({{x.x(), x.y(), x.z()},
                                 scene.camera.fx * p.x() / p.z() + scene.camera.cx + noise(random),
                                 scene.camera.fy * p.y() / p.z() + scene.camera.cy + noise(random)});
  }
  int failed = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    ResectionResult result;
    const bool found = resect(scene.views, scene.camera, {.seed = seed}, inliers, result).ok();
    failed += found && result.inliers > 690 ? 0 : 1;
  }
  EXPECT_EQ(failed, 0);
}

TEST(Resection, SameSeedSameBits) {
  make_scene(scene, 200, 0.5, 0.3, 0.5, 3);
  ResectionResult first;
  ResectionResult second;
  ASSERT_TRUE(resect(scene.views, scene.camera, {.seed = 9}, inliers, first).ok());
  ASSERT_TRUE(resect(scene.views, scene.camera, {.seed = 9}, inliers, second).ok());
  EXPECT_EQ(std::memcmp(&first.cam_from_world, &second.cam_from_world, sizeof(RigidTransform)), 0);
}

TEST(Resection, SaysNoWhenThereIsNoPose) {
  make_scene(scene, 100, 0.5, 0.3, 1.0, 3);  // nothing but wrong matches
  ResectionResult result;
  EXPECT_TRUE(resect(scene.views, scene.camera, {}, inliers, result).is(StatusCode::no_model));
  make_scene(scene, 10, 0.5, 0.3, 0, 3);
  EXPECT_TRUE(resect(scene.views, scene.camera, {}, inliers, result).is(StatusCode::too_few_matches));
  make_scene(scene, 30, 0.5, 0.3, 0, 3);
  scene.views[4].position[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(resect(scene.views, scene.camera, {}, inliers, result).is(StatusCode::invalid_argument));
  scene.views.clear();
  EXPECT_TRUE(resect(scene.views, scene.camera, {}, inliers, result).is(StatusCode::too_few_matches));
}

}  // namespace
}  // namespace ilp
