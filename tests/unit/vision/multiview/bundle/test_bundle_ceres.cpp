// The bundle adjustment against Ceres Solver, an established library, where it is installed.
#include <gtest/gtest.h>

#include <cstdio>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "tests/unit/vision/multiview/bundle/ceres_bundle.hpp"
#include "tests/unit/vision/multiview/bundle/ceres_windows.hpp"
#include "tests/unit/vision/multiview/bundle/dubrovnik_window.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp {
namespace {

#if defined(ILP_HAVE_CERES)

// Megabytes: static, as in flight.
BundleAdjuster adjuster;
BundleProblem problem;

/// Both to the very end from where `problem` is: one cost, one place.
void expect_one_minimum(BundleParams params, double centre_tolerance, double most_of_cost = 0.5) {
  params.max_iterations = 500;
  params.relative_tolerance = 1e-15;
  const test::CeresResult ceres = test::adjust_with_ceres(problem, params);
  // The adjuster stops as in flight, at a tolerance of its own.
  params.relative_tolerance = 1e-9;
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, params, result).ok());
  std::printf("%zu cameras, %u points, %u observations: cost %.6e -> %.9e, Ceres %.9e\n", problem.cameras.size(),
              result.points, result.observations, result.initial_cost, result.final_cost, ceres.final_cost);
  EXPECT_NEAR(result.initial_cost, ceres.initial_cost, 1e-10 * ceres.initial_cost);
  EXPECT_NEAR(result.final_cost, ceres.final_cost, 1e-6 * ceres.final_cost);
  EXPECT_LT(result.final_cost, most_of_cost * result.initial_cost) << "there was something to adjust";
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

TEST(BundleCeres, OutliersHaveTheSameMinimum) {
  disturbed_window({.cameras = 7, .points = 2000, .noise_px = 0.3, .step = 1.2});
  for (std::size_t i = 0; i < problem.observations.size(); i += 15) problem.observations[i].y += 20;
  expect_one_minimum({.robust_px = 1}, 1e-3);
}

TEST(BundleCeres, LargeWindowHasTheSameMinimum) {
  disturbed_window({.cameras = 12, .fixed = 4, .points = 4000, .noise_px = 0.3, .step = 1.2});
  expect_one_minimum({.robust_px = 1}, 1e-3);
}

TEST(BundleCeres, RealImagesHaveTheSameMinimum) {
  for (const char* name : {test::dubrovnik_five, test::dubrovnik_sixteen}) {
    SCOPED_TRACE(name);
    if (!test::read_dubrovnik(problem, name)) GTEST_SKIP() << "data set not present";
    expect_one_minimum({}, 1e-2);
    ASSERT_TRUE(test::read_dubrovnik(problem, name));
    // Twice the residuals: a smaller scale has more than one minimum.
    expect_one_minimum({.robust_px = 4}, 1e-2);
  }
}

class BundleCeresStrip : public testing::TestWithParam<const char*> {};

TEST_P(BundleCeresStrip, RecordedWindowsHaveTheSameMinimum) {
  const test::RecordedWindows strip(GetParam());
  if (strip.windows().empty()) GTEST_SKIP() << "no data in " << test::data_root << GetParam();
  for (const auto& window : strip.windows()) {
    SCOPED_TRACE(window->observations.size());
    problem = *window;
    expect_one_minimum({.robust_px = 0.5}, 1e-2, 1);  // as flown
    problem = *window;
    test::disturb(problem, 2, 5);
    expect_one_minimum({.robust_px = 1}, 1e-2);
  }
}

INSTANTIATE_TEST_SUITE_P(Recorded, BundleCeresStrip, testing::ValuesIn(test::recorded_strips),
                         [](const auto& tested) { return std::string(tested.param); });

#else

TEST(BundleCeres, HasTheSameMinimum) {
  GTEST_SKIP() << "Ceres Solver is not installed (libceres-dev)";
}

#endif

}  // namespace
}  // namespace ilp
