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
BundleResult result;

TEST(BundleLoss, CauchyCostIsTheLogarithm) {
  test::make_window({.points = 30, .noise_px = 1.5}, problem);
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 0, .robust_px = 2}, result).ok());
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
