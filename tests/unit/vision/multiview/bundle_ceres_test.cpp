// The bundle adjustment against Ceres Solver, an established library, where it is installed.
#include <gtest/gtest.h>

#include "fsw/vision/multiview/bundle_adjustment.hpp"
#include "tests/unit/vision/multiview/ceres_bundle.hpp"
#include "tests/unit/vision/multiview/dubrovnik_window.hpp"
#include "tests/unit/vision/multiview/synthetic_window.hpp"

namespace ilp {
namespace {

#if defined(ILP_HAVE_CERES)

// Megabytes: static, as in flight.
BundleAdjuster adjuster;
BundleProblem problem;

/// Both to the very end from where `problem` is: one cost, one place.
void expect_one_minimum(BundleParams params, double centre_tolerance) {
  params.max_iterations = 500;
  params.relative_tolerance = 1e-15;
  const test::CeresResult ceres = test::adjust_with_ceres(problem, params);
  // The adjuster stops as in flight, at a tolerance of its own.
  params.relative_tolerance = 1e-9;
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, params, result).ok());
  EXPECT_NEAR(result.initial_cost, ceres.initial_cost, 1e-10 * ceres.initial_cost);
  EXPECT_NEAR(result.final_cost, ceres.final_cost, 1e-6 * ceres.final_cost);
  EXPECT_LT(result.final_cost, 0.5 * result.initial_cost) << "there was something to adjust";
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(problem.cameras[i].pose.centre[k], ceres.centres[i][k], centre_tolerance);
    }
  }
}

void disturbed_window(const test::WindowScene& scene) {
  test::make_window(scene, problem);
  test::disturb(problem, 2, scene.seed + 10);
}

TEST(BundleCeres, LeastSquaresHaveTheSameMinimum) {
  for (const unsigned seed : {1U, 2U}) {
    disturbed_window({.cameras = 7, .points = 2000, .noise_px = 0.3, .step = 1.2, .seed = seed});
    expect_one_minimum({}, 1e-4);
  }
}

TEST(BundleCeres, HuberHasTheSameMinimumWithOutliers) {
  disturbed_window({.cameras = 7, .points = 2000, .noise_px = 0.3, .step = 1.2});
  for (std::size_t i = 0; i < problem.observations.size(); i += 15) problem.observations[i].y += 20;
  expect_one_minimum({.robust_px = 1}, 1e-3);
}

TEST(BundleCeres, CauchyHasTheSameMinimum) {
  disturbed_window({.cameras = 5, .points = 500, .noise_px = 0.3});
  expect_one_minimum({.robust_px = 1, .loss = BundleLoss::cauchy}, 1e-3);
}

TEST(BundleCeres, LargeWindowHasTheSameMinimum) {
  disturbed_window({.cameras = 12, .fixed = 4, .points = 4000, .noise_px = 0.3, .step = 1.2});
  expect_one_minimum({.robust_px = 1}, 1e-3);
}

TEST(BundleCeres, RealImagesHaveTheSameMinimum) {
  if (!test::read_dubrovnik(problem)) GTEST_SKIP() << "data set not present";
  expect_one_minimum({}, 1e-2);
  ASSERT_TRUE(test::read_dubrovnik(problem));
  expect_one_minimum({.robust_px = 1}, 1e-2);
}

#else

TEST(BundleCeres, HasTheSameMinimum) {
  GTEST_SKIP() << "Ceres Solver is not installed (libceres-dev)";
}

#endif

}  // namespace
}  // namespace ilp
