// Priors and losses of the bundle adjustment.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "fsw/base/argument.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp {
namespace {

// Megabytes: static, as in flight.
BundleAdjuster adjuster;
BundleProblem problem;
BundleProblem truth;
BundleCovariance joint;
BundleResult result;

double attitude_error(const double q[4], std::size_t camera, int axis) {
  const Mat3 turn =
      rotation_from_quaternion(problem.cameras[camera].pose.q_cam_from_world) * rotation_from_quaternion(q).transpose();
  return vector_from_rotation(turn)[axis];
}

BundleAttitudePrior attitude_of(std::size_t camera, const Vec3& error, double sigma) {
  BundleAttitudePrior prior;
  prior.camera = static_cast<std::uint16_t>(camera);
  quaternion_from_rotation(
      rotation_from_vector(error) * rotation_from_quaternion(truth.cameras[camera].pose.q_cam_from_world),
      prior.q_cam_from_world);
  for (double& s : prior.sigma_rad) s = sigma;
  return prior;
}

TEST(BundlePrior, HeightsTellTheScaleOfAClimb) {
  // One fixed camera: images alone leave the scale open. The heights of a climbing balloon determine it.
  test::make_window({.fixed = 1, .points = 150, .noise_px = 0.3}, truth);
  for (std::size_t i = 0; i < truth.cameras.size(); ++i)
    truth.cameras[i].pose.centre[2] += 0.8 * static_cast<double>(i);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.3);
  for (BundleObservation& o : truth.observations) {
    const double* x = truth.points[o.point].position;
    const BundleCamera& camera = truth.cameras[o.camera];
    const Vec3 c = cam_from_world(camera.pose) * Vec3(x[0], x[1], x[2]);
    o.x = camera.fx * c.x() / c.z() + camera.cx + noise(random);
    o.y = camera.fy * c.y() / c.z() + camera.cy + noise(random);
  }
  problem = truth;
  const double* origin = truth.cameras[0].pose.centre;
  const auto shrink = [&](double* x) {
    for (int k = 0; k < 3; ++k) x[k] = origin[k] + 0.8 * (x[k] - origin[k]);
  };
  for (std::size_t i = 1; i < 5; ++i) {
    shrink(problem.cameras[i].pose.centre);
    (void)problem.heights.push_back(
        {static_cast<std::uint16_t>(i), {0, 0, 1}, truth.cameras[i].pose.centre[2] + 0.01 * noise(random), 0.01});
  }
  for (BundlePoint& point : problem.points) shrink(point.position);
  ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 100, .relative_tolerance = 1e-12}, result, &joint).ok());
  ASSERT_TRUE(result.covariance_valid);
  ASSERT_TRUE(joint.valid);
  const double sigma = result.cameras[4].sigma[0];
  EXPECT_LT(sigma, 0.2);
  EXPECT_NEAR(problem.cameras[4].pose.centre[0], truth.cameras[4].pose.centre[0], 3 * sigma) << "it began 2 short";
}

TEST(BundlePrior, AttitudeHoldsACameraThatImagesHardlyHold) {
  // Few points, much noise, one good attitude sensor.
  double with = 0;
  double without = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    test::make_window({.points = 12, .noise_px = 3, .seed = seed}, truth);
    problem = truth;
    ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 50}, result).ok());
    const double* q = truth.cameras[4].pose.q_cam_from_world;
    for (int k = 0; k < 3; ++k) without += std::pow(attitude_error(q, 4, k), 2);
    problem = truth;
    (void)problem.attitudes.push_back(attitude_of(4, Vec3(2e-4, -2e-4, 2e-4), 2e-4));
    ASSERT_TRUE(adjuster.run(problem, {.max_iterations = 50, .observation_sigma_px = 3}, result).ok());
    for (int k = 0; k < 3; ++k) with += std::pow(attitude_error(q, 4, k), 2);
  }
  EXPECT_LT(std::sqrt(with), 0.3 * std::sqrt(without));
}

TEST(BundlePrior, MinimumHasNoGradient) {
  // Priors that contradict the images, far from small: the cost must rise whichever way a camera is moved. A wrong
  // derivative would leave the minimum elsewhere, or not be reached within the iterations.
  test::make_window({.points = 60}, truth);
  problem = truth;
  (void)problem.attitudes.push_back(attitude_of(3, Vec3(0.3, -0.2, 0.4), 0.004));
  problem.attitudes[0].sigma_rad[2] = 0.01;
  const Vec3 direction = Vec3(0.3, -0.5, 0.8).normalized();
  (void)problem.heights.push_back({4, {direction.x(), direction.y(), direction.z()}, 9, 0.02});
  const BundleParams params{.max_iterations = 200, .relative_tolerance = 1e-15};
  ASSERT_TRUE(adjuster.run(problem, params, result).ok());
  EXPECT_LT(result.iterations, 120U);
  const double minimum = result.final_cost;
  static BundleProblem moved;
  for (const std::size_t camera : {2U, 3U, 4U}) {
    for (int k = 0; k < 6; ++k) {
      double slope = 0;
      double curvature = 0;
      const double h = 1e-5;
      for (const double sign : {-1.0, 1.0}) {
        moved = problem;
        Pose& pose = moved.cameras[camera].pose;
        if (k < 3) {
          quaternion_from_rotation(
              rotation_from_vector(sign * h * Vec3::Unit(k)) * rotation_from_quaternion(pose.q_cam_from_world),
              pose.q_cam_from_world);
        } else {
          pose.centre[k - 3] += sign * h;
        }
        BundleResult there;
        ASSERT_TRUE(adjuster.run(moved, {.max_iterations = 0}, there).ok());
        slope += sign * (there.initial_cost - minimum);
        curvature += there.initial_cost - minimum;
      }
      EXPECT_GT(curvature, 0);
      EXPECT_LT(std::fabs(slope), 1e-2 * curvature) << "camera " << camera << ", parameter " << k;
    }
  }
}

TEST(BundlePrior, CovarianceIsTheScatter) {
  // Sensors that matter, and a wrong idea of the observations' noise: the priors' own sigmas are absolute.
  for (const double assumed_px : {0.4, 1.0}) {
    double mahalanobis = 0;
    constexpr int draws = 600;
    test::make_window({.points = 40, .noise_px = 0, .seed = 7}, truth);
    std::mt19937 random(17);
    std::normal_distribution<double> normal(0, 1);
    for (int draw = 0; draw < draws; ++draw) {
      problem = truth;
      for (BundleObservation& o : problem.observations) {
        o.x += 0.4 * normal(random);
        o.y += 0.4 * normal(random);
      }
      for (std::size_t i = 2; i < 5; ++i) {
        (void)problem.heights.push_back({static_cast<std::uint16_t>(i),
                                         {0, 0, 1},
                                         truth.cameras[i].pose.centre[2] + 0.002 * normal(random),
                                         0.002});
        (void)problem.attitudes.push_back(
            attitude_of(i, 4e-4 * Vec3(normal(random), normal(random), normal(random)), 4e-4));
      }
      ASSERT_TRUE(
          adjuster.run(problem, {.relative_tolerance = 1e-10, .observation_sigma_px = assumed_px}, result, &joint)
              .ok());
      const Eigen::Map<const Eigen::Matrix<double, 18, 18>> covariance(joint.conditional.data());
      Eigen::Matrix<double, 18, 1> error;
      for (std::size_t i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          const auto row = static_cast<Eigen::Index>(6 * i) + k;
          error[row] = attitude_error(truth.cameras[2 + i].pose.q_cam_from_world, 2 + i, k);
          error[row + 3] = problem.cameras[2 + i].pose.centre[k] - truth.cameras[2 + i].pose.centre[k];
        }
      }
      mahalanobis += error.dot(covariance.ldlt().solve(error)) / 18;
    }
    EXPECT_NEAR(mahalanobis / draws, 1, 0.12) << assumed_px;
  }
}

TEST(BundlePrior, ThoseOfFixedCamerasMoveNothing) {
  test::make_window({.points = 60}, problem);
  truth = problem;
  const BundleParams params{.max_iterations = 100, .relative_tolerance = 1e-14};
  ASSERT_TRUE(adjuster.run(problem, params, result).ok());
  const double cost = result.final_cost;
  static BundleProblem other;
  other = truth;
  (void)other.heights.push_back({0, {0, 0, 1}, 11, 0.1});
  (void)other.attitudes.push_back(attitude_of(1, Vec3(0.1, 0, 0), 0.01));
  ASSERT_TRUE(adjuster.run(other, params, result).ok());
  EXPECT_GT(result.final_cost, cost + 1);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(other.cameras[3].pose.centre[k], problem.cameras[3].pose.centre[k], 1e-6);
}

TEST(BundlePrior, RefusesMalformedOnes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change) {
    test::make_window({.points = 20}, problem);
    (void)problem.heights.push_back({2, {0, 0, 1}, 10, 0.1});
    (void)problem.attitudes.push_back({});
    problem.attitudes[0].camera = 3;
    change();
    const Status status = adjuster.run(problem, {}, result);
    return status.is(StatusCode::invalid_argument) ? name_of(static_cast<Argument>(status.a)) : "";
  };
  EXPECT_STREQ(refused([] {}), "");
  EXPECT_STREQ(refused([] { problem.heights[0].camera = 5; }), "height_prior");
  EXPECT_STREQ(refused([&] { problem.heights[0].value = nan; }), "height_prior");
  EXPECT_STREQ(refused([] { problem.heights[0].sigma = 0; }), "height_prior");
  EXPECT_STREQ(refused([] { problem.heights[0].direction[2] = 2; }), "height_prior");
  EXPECT_STREQ(refused([] { problem.attitudes[0].camera = 5; }), "attitude_prior");
  EXPECT_STREQ(refused([] { problem.attitudes[0].q_cam_from_world[0] = 0; }), "attitude_prior");
  EXPECT_STREQ(refused([&] { problem.attitudes[0].sigma_rad[1] = nan; }), "attitude_prior");
  EXPECT_STREQ(refused([] { problem.attitudes[0].sigma_rad[1] = std::numeric_limits<double>::infinity(); }),
               "attitude_prior");
}

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
