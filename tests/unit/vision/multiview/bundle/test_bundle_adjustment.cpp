#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "tests/unit/vision/multiview/bundle/dubrovnik_window.hpp"
#include "tests/unit/vision/multiview/bundle/reference_adjustment.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp {
namespace {

using test::ReferenceAdjustment;
using test::WindowScene;

// Megabytes: static, as in flight.
BundleAdjuster adjuster;
BundleProblem problem;
BundleProblem truth;

double centre_error(std::size_t camera) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = problem.cameras[camera].pose.centre[k] - truth.cameras[camera].pose.centre[k];
    sum += d * d;
  }
  return std::sqrt(sum);
}

TEST(BundleAdjustment, RecoversTheTruthFromExactObservations) {
  test::make_window({.noise_px = 0}, truth);
  problem = truth;
  test::disturb(problem, 2, 5);
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 30, .relative_tolerance = 1e-12}, result).ok());
  EXPECT_GT(result.initial_rms_px, 1);
  EXPECT_LT(result.final_rms_px, 1e-7);
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) EXPECT_LT(centre_error(i), 1e-8);
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(problem.points[i].position[k], truth.points[i].position[k], 1e-6);
  }
}

/// Everything that an adjustment gives, as bytes.
std::string bytes_of_adjustment(VectorWidth vectors, const BundleParams& params) {
  static BundleCovariance covariance;
  use_vectors(vectors);
  problem = truth;
  test::disturb(problem, 3, 7);
  BundleResult result;
  EXPECT_TRUE(adjuster.run(problem, params, result, &covariance).ok());
  use_vectors(widest_vectors());
  std::string bytes(reinterpret_cast<const char*>(&covariance), sizeof(covariance));
  for (const BundleCamera& camera : problem.cameras) {
    bytes.append(reinterpret_cast<const char*>(&camera.pose), sizeof(camera.pose));
  }
  bytes.append(reinterpret_cast<const char*>(problem.points.data()), problem.points.size() * sizeof(BundlePoint));
  for (const double value : {result.initial_cost, result.final_cost, result.initial_rms_px, result.final_rms_px}) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  return bytes;
}

TEST(BundleAdjustment, VectorsOfBothWidthsGiveTheSameBytes) {
  if (widest_vectors() == VectorWidth::bytes16) GTEST_SKIP() << "this processor has one width";
  // Points that one, two, three or more others share their cameras with.
  for (const int points : {1, 2, 3, 61, 400}) {
    for (const BundleParams& params : {BundleParams{}, BundleParams{.robust_px = 1}}) {
      test::make_window({.cameras = 6, .points = points, .noise_px = 1}, truth);
      EXPECT_TRUE(bytes_of_adjustment(VectorWidth::bytes16, params) ==
                  bytes_of_adjustment(VectorWidth::bytes32, params))
          << points << " points, bound " << params.robust_px << " px";
    }
  }
}

TEST(BundleAdjustment, ReachesTheMinimumOfAnIndependentSolver) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    test::make_window({.points = 150, .seed = seed}, problem);
    test::disturb(problem, 2, seed + 10);
    ReferenceAdjustment reference(problem);
    const double initial = reference.cost();
    const double minimum = reference.minimise(40);
    BundleResult result;
    ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
    EXPECT_TRUE(result.converged);
    EXPECT_NEAR(result.initial_cost, initial, 1e-9 * initial);
    EXPECT_NEAR(result.final_cost, minimum, 1e-5 * minimum);
    EXPECT_LE(result.iterations, 6U) << "a wrong derivative shows as slow convergence";
    for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
      const Eigen::Vector3d expected = reference.centre(i);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(problem.cameras[i].pose.centre[k], expected[k], 1e-4);
    }
  }
}

TEST(BundleAdjustment, ReachesTheRobustMinimumWithOutliers) {
  test::make_window({.points = 150, .noise_px = 0.3}, truth);
  problem = truth;
  for (std::size_t i = 0; i < problem.observations.size(); i += 12) problem.observations[i].x += 25;
  test::disturb(problem, 1, 4);
  ReferenceAdjustment reference(problem);
  const double minimum = reference.minimise(60, 1.0);
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 60, .relative_tolerance = 1e-9, .robust_px = 1}, result).ok());
  EXPECT_NEAR(result.final_cost, minimum, 1e-5 * minimum);
  const double robust_error = centre_error(4);

  problem = truth;
  for (std::size_t i = 0; i < problem.observations.size(); i += 12) problem.observations[i].x += 25;
  ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
  EXPECT_LT(robust_error, 0.5 * centre_error(4)) << "the bound must keep outliers from bending the window";
}

TEST(BundleAdjustment, FixedCamerasKeepTheirBits) {
  test::make_window({.fixed = 3}, problem);
  test::disturb(problem, 2, 5);
  truth = problem;
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(std::memcmp(&problem.cameras[i].pose, &truth.cameras[i].pose, sizeof(Pose)), 0);
  }
  EXPECT_GT(centre_error(3), 0);
}

TEST(BundleAdjustment, CovarianceEqualsTheFullInverse) {
  // The covariance is where every analytic derivative and the Schur complement meet.
  test::make_window({.points = 60}, problem);
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 50, .relative_tolerance = 1e-12}, result).ok());
  ASSERT_TRUE(result.covariance_valid);
  const ReferenceAdjustment reference(problem);
  const double redundancy =
      2.0 * static_cast<double>(problem.observations.size()) - 3.0 * static_cast<double>(problem.points.size()) - 6 * 3;
  const double variance = 2 * result.final_cost / redundancy;
  EXPECT_NEAR(std::sqrt(variance), 0.5, 0.1) << "the noise that was put in";
  for (std::size_t camera = 2; camera < 5; ++camera) {
    const Eigen::Matrix3d expected = variance * reference.centre_covariance(camera);
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(result.cameras[camera].sigma[r], std::sqrt(expected(r, r)), 1e-3 * std::sqrt(expected(r, r)));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(result.cameras[camera].matrix[3 * r + c], expected(r, c), 1e-3 * expected.norm());
      }
    }
  }
  EXPECT_EQ(result.cameras[0].sigma[0], 0);
}

TEST(BundleAdjustment, SigmaPredictsTheScatterOfTheErrors) {
  // Over many draws of the noise the errors, in units of their sigma, have a mean square of one.
  double sum = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    test::make_window({.points = 100, .noise_px = 0, .seed = 7}, truth);
    problem = truth;
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.4);
    for (BundleObservation& o : problem.observations) {
      o.x += noise(random);
      o.y += noise(random);
    }
    BundleResult result;
    ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
    for (std::size_t i = 2; i < 5; ++i) {
      for (int k = 0; k < 3; ++k) {
        const double error = problem.cameras[i].pose.centre[k] - truth.cameras[i].pose.centre[k];
        sum += error * error / (result.cameras[i].sigma[k] * result.cameras[i].sigma[k]);
        ++count;
      }
    }
  }
  EXPECT_NEAR(sum / count, 1, 0.35);
}

TEST(BundleAdjustment, HoldsTheScaleWhenOneCameraIsFixed) {
  test::make_window({.fixed = 1}, problem);
  test::disturb(problem, 2, 5);
  problem.hold = {true, 0, 1};
  const auto baseline = [] {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = problem.cameras[1].pose.centre[k] - problem.cameras[0].pose.centre[k];
      sum += d * d;
    }
    return std::sqrt(sum);
  };
  const double before = baseline();
  ReferenceAdjustment reference(problem);
  const double minimum = reference.minimise(60);  // the scale is free there, but the cost does not depend on it
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
  EXPECT_NEAR(baseline(), before, 1e-12 * before);
  EXPECT_NEAR(result.final_cost, minimum, 1e-4 * minimum);
  ASSERT_TRUE(result.covariance_valid);
  EXPECT_LT(result.cameras[4].sigma[0], 0.1);
  const double* c0 = problem.cameras[0].pose.centre;
  const double* c1 = problem.cameras[1].pose.centre;
  const Vec3 along = Vec3(c1[0] - c0[0], c1[1] - c0[1], c1[2] - c0[2]).normalized();
  const Eigen::Map<const Eigen::Matrix3d> covariance(result.cameras[1].matrix);
  EXPECT_LT(std::sqrt(along.dot(covariance * along)), 1e-5) << "the held direction is known";
  EXPECT_GT(result.cameras[1].sigma[2], 1e-3);
}

TEST(BundleAdjustment, ConvergesWithNoFixedCamera) {
  test::make_window({.fixed = 0, .points = 150}, problem);
  test::disturb(problem, 2, 5);
  ReferenceAdjustment reference(problem);
  const double minimum = reference.minimise(60);
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
  EXPECT_NEAR(result.final_cost, minimum, 1e-4 * minimum);
  EXPECT_FALSE(result.covariance_valid);
}

TEST(BundleAdjustment, ResumesToTheLastBitAfterEveryStep) {
  test::make_window({.noise_px = 0.5}, problem);
  test::disturb(problem, 2, 5);
  static BundleProblem interrupted;
  interrupted = problem;
  const BundleParams params{.relative_tolerance = 1e-10, .robust_px = 1};
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, params, result).ok());

  static BundleAdjuster other;
  ASSERT_TRUE(other.begin(interrupted, params).ok());
  BundleProgress progress = other.progress();
  while (!progress.descent.done) {
    ASSERT_TRUE(other.resume(interrupted, params, progress).ok());
    ASSERT_TRUE(other.step().ok());
    progress = other.progress();
  }
  BundleResult resumed;
  ASSERT_TRUE(other.finish(resumed).ok());
  EXPECT_EQ(resumed.iterations, result.iterations);
  EXPECT_EQ(resumed.final_cost, result.final_cost);
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    EXPECT_EQ(std::memcmp(&problem.cameras[i].pose, &interrupted.cameras[i].pose, sizeof(Pose)), 0);
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    EXPECT_EQ(std::memcmp(&problem.points[i], &interrupted.points[i], sizeof(BundlePoint)), 0);
  }
}

TEST(BundleAdjustment, OrderOfObservationsDoesNotMatter) {
  test::make_window({}, problem);
  test::disturb(problem, 2, 5);
  truth = problem;
  for (std::size_t i = 0, j = truth.observations.size() - 1; i < j; ++i, --j) {
    std::swap(truth.observations[i], truth.observations[j]);
  }
  BundleResult forward;
  BundleResult backward;
  ASSERT_TRUE(adjuster.run(problem, {}, forward).ok());
  ASSERT_TRUE(adjuster.run(truth, {}, backward).ok());
  EXPECT_EQ(forward.final_cost, backward.final_cost);
}

TEST(BundleAdjustment, DropsWhatCannotBeUsed) {
  test::make_window({.points = 80}, problem);
  // One point behind every camera, one with a single observation: both keep their place.
  const auto behind = static_cast<std::uint16_t>(problem.points.size());
  (void)problem.points.push_back({{2, 0, 50}});
  (void)problem.observations.push_back({0, behind, 300, 200});
  (void)problem.observations.push_back({1, behind, 300, 200});
  (void)problem.points.push_back({{2, 0, 0}});
  (void)problem.observations.push_back({2, static_cast<std::uint16_t>(behind + 1), 300, 200});
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {}, result).ok());
  EXPECT_EQ(result.points, 80U);
  EXPECT_EQ(result.dropped_observations, 3U);
  EXPECT_LT(result.final_rms_px, 1);
  EXPECT_EQ(problem.points[behind].position[2], 50);
}

TEST(BundleAdjustment, RefusesMalformedProblems) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  BundleResult result;
  const auto status = [&] { return adjuster.run(problem, {}, result); };
  const auto refused = [&] { return static_cast<Argument>(status().a); };
  const auto reset = [] { test::make_window({.points = 20}, problem); };
  reset();
  problem.cameras[3].pose.centre[1] = nan;
  EXPECT_EQ(refused(), Argument::camera);
  reset();
  problem.cameras[3].fx = 0;
  EXPECT_EQ(refused(), Argument::camera);
  reset();
  problem.points[7].position[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refused(), Argument::point);
  reset();
  problem.observations[5].x = nan;
  EXPECT_EQ(refused(), Argument::observation);
  reset();
  problem.observations[5].camera = 5;
  EXPECT_EQ(refused(), Argument::observation);
  reset();
  problem.observations[5].point = 20;
  EXPECT_EQ(refused(), Argument::observation);
  reset();
  (void)problem.observations.push_back(problem.observations[0]);
  EXPECT_EQ(refused(), Argument::observation) << "two observations of a point in one camera";
  reset();
  problem.hold = {true, 0, 2};
  EXPECT_EQ(refused(), Argument::scale_hold) << "two cameras are fixed: nothing to hold";
  problem = {};
  EXPECT_TRUE(status().is(StatusCode::no_model));
}

TEST(BundleAdjustment, RefusesMalformedParameters) {
  const double infinity = std::numeric_limits<double>::infinity();
  BundleResult result;
  test::make_window({.points = 20}, problem);
  for (const BundleParams& params :
       {BundleParams{.relative_tolerance = -1}, BundleParams{.robust_px = infinity}, BundleParams{.robust_px = -1}}) {
    const Status status = adjuster.run(problem, params, result);
    EXPECT_TRUE(status.is(StatusCode::invalid_argument));
    EXPECT_EQ(static_cast<Argument>(status.a), Argument::adjustment_parameters);
  }
}

TEST(BundleAdjustment, WindowsWithoutUseHaveNoModel) {
  BundleResult result;
  test::make_window({.points = 20}, problem);
  problem.observations.clear();
  EXPECT_TRUE(adjuster.run(problem, {}, result).is(StatusCode::no_model)) << "no observation";
  test::make_window({.points = 20}, problem);
  for (BundlePoint& point : problem.points) point.position[2] += 1000;
  EXPECT_TRUE(adjuster.run(problem, {}, result).is(StatusCode::no_model)) << "all behind their cameras";
  test::make_window({.points = 20}, problem);
  problem.observations[3].x = 1e200;
  EXPECT_TRUE(adjuster.run(problem, {}, result).is(StatusCode::no_model)) << "the cost overflows";
}

TEST(BundleAdjustment, PointsMoveWhereAllCamerasAreFixed) {
  test::make_window({.fixed = 5, .points = 60, .noise_px = 0}, truth);
  problem = truth;
  for (BundlePoint& point : problem.points) point.position[2] += 0.2;
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 30, .relative_tolerance = 1e-12}, result).ok());
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(std::memcmp(&problem.cameras[i].pose, &truth.cameras[i].pose, sizeof(Pose)), 0);
  }
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_NEAR(problem.points[i].position[2], truth.points[i].position[2], 1e-5);
  }
  EXPECT_FALSE(result.covariance_valid);
}

TEST(BundleAdjustment, ReachesTheMinimumOnRealImages) {
  if (!test::read_dubrovnik(problem)) GTEST_SKIP() << "data set not present";
  ReferenceAdjustment reference(problem);
  const double initial = reference.cost();
  const double minimum = reference.minimise(60);
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 100, .relative_tolerance = 1e-9}, result).ok());
  EXPECT_EQ(result.observations, 4305U);
  EXPECT_NEAR(result.initial_cost, initial, 1e-6 * initial);
  EXPECT_LT(result.final_cost, 0.2 * initial);
  EXPECT_NEAR(result.final_cost, minimum, 1e-4 * minimum);
}

}  // namespace
}  // namespace ilp
