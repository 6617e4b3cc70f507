// Robust losses of the bundle adjustment.
#include <gtest/gtest.h>

#include <cmath>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp {
namespace {

// Megabytes: static, as in flight.
BundleAdjuster adjuster;
BundleProblem problem;
BundleProblem truth;
BundleResult result;

TEST(BundleLoss, CauchyForgetsOutliersBetterThanHuber) {
  double error[2] = {0, 0};
  for (const bool cauchy : {false, true}) {
    test::make_window({.points = 150, .noise_px = 0.3}, truth);
    problem = truth;
    for (std::size_t i = 0; i < problem.observations.size(); i += 8) problem.observations[i].x += 40;
    BundleParams params{.max_iterations = 100, .relative_tolerance = 1e-9, .robust_px = 1};
    if (cauchy) params.loss = BundleLoss::cauchy;
    ASSERT_TRUE(adjuster.run(problem, params, result).ok());
    for (std::size_t i = 2; i < 5; ++i) {
      for (int k = 0; k < 3; ++k) {
        error[cauchy ? 1 : 0] += std::pow(problem.cameras[i].pose.centre[k] - truth.cameras[i].pose.centre[k], 2);
      }
    }
  }
  EXPECT_LT(std::sqrt(error[1]), 0.7 * std::sqrt(error[0]));
}

TEST(BundleLoss, CauchyCostIsTheLogarithm) {
  test::make_window({.points = 30, .noise_px = 1.5}, problem);
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 0, .robust_px = 2, .loss = BundleLoss::cauchy}, result).ok());
  double expected = 0;
  for (const BundleObservation& o : problem.observations) {
    const double* x = problem.points[o.point].position;
    const BundleCamera& camera = problem.cameras[o.camera];
    const Vec3 c = cam_from_world(camera.pose) * Vec3(x[0], x[1], x[2]);
    const double u = camera.fx * c.x() / c.z() + camera.cx - o.x;
    const double v = camera.fy * c.y() / c.z() + camera.cy - o.y;
    expected += 0.5 * 4 * std::log1p((u * u + v * v) / 4);
  }
  EXPECT_NEAR(result.final_cost, expected, 1e-9 * expected);
}

}  // namespace
}  // namespace ilp
