#include "fsw/vision/multiview/bundle/bundle_covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Megabytes: static, as in flight.
BundleAdjuster adjuster;
BundleProblem problem;
BundleProblem truth;
BundleCovariance joint;

constexpr BundleParams to_the_end{.max_iterations = 50, .relative_tolerance = 1e-14};

Matrix conditional() {
  const int n = 6 * joint.free_count;
  return Eigen::Map<const Matrix>(joint.conditional.data(), n, n);
}
Matrix transfer() {
  return Eigen::Map<const Matrix>(joint.transfer.data(), 6 * joint.free_count, 6 * joint.fixed_count);
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Rotation vector and centre that lead from one pose to another, in the parameters of the covariance.
Vector6 difference(const Pose& from, const Pose& to) {
  Vector6 d;
  d.head<3>() = vector_from_rotation(rotation_from_quaternion(to.q_cam_from_world) *
                                     rotation_from_quaternion(from.q_cam_from_world).transpose());
  for (int k = 0; k < 3; ++k) d[3 + k] = to.centre[k] - from.centre[k];
  return d;
}

Pose moved(const Pose& pose, const Vector6& d) {
  Pose out;
  quaternion_from_rotation(rotation_from_vector(d.head<3>()) * rotation_from_quaternion(pose.q_cam_from_world),
                           out.q_cam_from_world);
  for (int k = 0; k < 3; ++k) out.centre[k] = pose.centre[k] + d[3 + k];
  return out;
}

/// All free cameras of `problem` against another state of theirs.
Eigen::VectorXd free_difference(const BundleProblem& from) {
  Eigen::VectorXd d(6 * joint.free_count);
  for (int i = 0; i < joint.free_count; ++i) {
    const std::size_t camera = joint.free_camera[static_cast<std::size_t>(i)];
    d.segment<6>(6 * i) = difference(from.cameras[camera].pose, problem.cameras[camera].pose);
  }
  return d;
}

struct Scatter {
  double mahalanobis;  ///< mean of e^T Sigma^-1 e per parameter: 1 where the covariance is right
  double worst_ratio;  ///< largest ratio between drawn and given sigma of one parameter, either way round
};

struct Draws {
  int count = 1000;
  double noise_px = 0.4;
  double outlier_share = 0;
  double outlier_px = 0;
  Matrix fixed_sqrt = {};  ///< L of the fixed cameras' covariance L L^T; empty = without error
};

/// Adjusts a window again and again with new noise, and compares its errors with the covariances that come with them.
Scatter scatter(const test::WindowScene& scene, const BundleParams& params, const Draws& draws) {
  test::make_window(scene, truth);
  std::mt19937 random(99);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  double mahalanobis = 0;
  Eigen::ArrayXd drawn, given;
  BundleResult result;
  for (int draw = 0; draw < draws.count; ++draw) {
    problem = truth;
    for (BundleObservation& o : problem.observations) {
      const double sigma = uniform(random) < draws.outlier_share ? draws.outlier_px : draws.noise_px;
      o.x += sigma * normal(random);
      o.y += sigma * normal(random);
    }
    if (draws.fixed_sqrt.size() > 0) {
      Eigen::VectorXd unit(draws.fixed_sqrt.cols());
      for (double& e : unit) e = normal(random);
      const Eigen::VectorXd error = draws.fixed_sqrt * unit;
      for (std::size_t i = 0; i < static_cast<std::size_t>(scene.fixed); ++i) {
        Pose& pose = problem.cameras[i].pose;
        pose = moved(pose, error.segment<6>(6 * static_cast<Eigen::Index>(i)));
      }
    }
    EXPECT_TRUE(adjuster.run(problem, params, result, &joint).ok());
    EXPECT_TRUE(joint.valid);
    Matrix covariance = conditional();
    if (draws.fixed_sqrt.size() > 0) {
      const Matrix spread = transfer() * draws.fixed_sqrt;
      covariance += spread * spread.transpose();
    }
    const Eigen::VectorXd error = free_difference(truth);
    mahalanobis += error.dot(covariance.ldlt().solve(error)) / static_cast<double>(error.size());
    if (draw == 0) drawn = given = Eigen::ArrayXd::Zero(error.size());
    drawn += error.array().square();
    given += covariance.diagonal().array();
  }
  const Eigen::ArrayXd ratio = (drawn / given).sqrt();
  return {mahalanobis / draws.count, std::max(ratio.maxCoeff(), 1 / ratio.minCoeff())};
}

TEST(BundleCovariance, IsTheScatterOfTheFreeCameras) {
  const Scatter s = scatter({.points = 80, .noise_px = 0, .seed = 7}, {}, {});
  EXPECT_EQ(joint.free_count, 3);
  EXPECT_EQ(joint.fixed_count, 2);
  EXPECT_NEAR(s.mahalanobis, 1, 0.1);
  EXPECT_LT(s.worst_ratio, 1.1);
}

TEST(BundleCovariance, IsTheScatterUnderALoss) {
  const test::WindowScene scene{.points = 80, .noise_px = 0, .seed = 7};
  const Scatter wide = scatter(scene, {.max_iterations = 50, .robust_px = 1}, {});
  EXPECT_NEAR(wide.mahalanobis, 1, 0.15);
  EXPECT_LT(wide.worst_ratio, 1.15);
  const Scatter outliers =
      scatter(scene, {.max_iterations = 50, .robust_px = 1}, {.outlier_share = 0.08, .outlier_px = 6});
  EXPECT_NEAR(outliers.mahalanobis, 1, 0.2);
  EXPECT_LT(outliers.worst_ratio, 1.15);
  // A scale as small as the noise: the weights themselves follow the noise.
  const Scatter narrow = scatter(scene, {.max_iterations = 50, .robust_px = 0.4}, {});
  EXPECT_LT(narrow.mahalanobis, 2.2);
  EXPECT_LT(narrow.worst_ratio, 1.5);
}

TEST(BundleCovariance, PropagatesTheErrorsOfTheFixedCameras) {
  // As at the end of a strip: the fixed cameras have drifted together, by a turn, a shift and a scale, and a little
  // against each other. (Where they contradict each other by more, the residuals show more than the noise.)
  const test::WindowScene scene{.points = 80, .noise_px = 0, .seed = 7};
  test::make_window(scene, truth);
  Matrix sqrt = Matrix::Zero(12, 19);
  for (int i = 0; i < 2; ++i) {
    const Pose& pose = truth.cameras[static_cast<std::size_t>(i)].pose;
    const Eigen::Map<const Vec3> centre(pose.centre);
    sqrt.block<3, 3>(6 * i, 0) = -6e-3 * rotation_from_quaternion(pose.q_cam_from_world);
    sqrt.block<3, 3>(6 * i + 3, 0) = -6e-3 * cross_matrix(centre);
    sqrt.block<3, 3>(6 * i + 3, 3) = 0.06 * Mat3::Identity();
    sqrt.block<3, 1>(6 * i + 3, 6) = 6e-3 * centre;
    sqrt.block<3, 3>(6 * i, 7 + 6 * i) = 5e-5 * Mat3::Identity();
    sqrt.block<3, 3>(6 * i + 3, 10 + 6 * i) = 5e-4 * Mat3::Identity();
  }
  const Scatter s = scatter(scene, {}, {.fixed_sqrt = sqrt});
  EXPECT_GT((transfer() * sqrt).norm(), 2 * std::sqrt(conditional().trace())) << "the fixed cameras' part must matter";
  EXPECT_NEAR(s.mahalanobis, 1, 0.1);
  EXPECT_LT(s.worst_ratio, 1.1);
}

TEST(BundleCovariance, AgreesWithThePositionCovariances) {
  test::make_window({.points = 80}, problem);
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, {}, result, &joint).ok());
  const Matrix all = conditional();
  EXPECT_EQ((all - all.transpose()).norm(), 0);
  for (int i = 0; i < joint.free_count; ++i) {
    const auto& own = result.cameras[joint.free_camera[static_cast<std::size_t>(i)]];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(all(6 * i + 3 + r, 6 * i + 3 + c), own.matrix[3 * r + c], 1e-9 * own.sigma[r] * own.sigma[c]);
      }
    }
  }
}

TEST(BundleCovariance, TransferIsTheDerivativeByTheFixedCameras) {
  // Fixed and free cameras in mixed order, and more than two fixed ones.
  test::make_window({.cameras = 6, .points = 120, .noise_px = 1e-4}, truth);
  for (std::size_t i = 0; i < 6; ++i) truth.cameras[i].fixed = i == 0 || i == 2 || i == 5;
  problem = truth;
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, to_the_end, result, &joint).ok());
  ASSERT_TRUE(joint.valid);
  EXPECT_EQ(joint.fixed_camera[1], 2);
  EXPECT_EQ(joint.free_camera[0], 1);
  const Matrix analytic = transfer();
  static BundleProblem plus;
  for (int f = 0; f < 3; ++f) {
    for (int k = 0; k < 6; ++k) {
      const double h = 1e-5;
      const std::size_t camera = joint.fixed_camera[static_cast<std::size_t>(f)];
      problem = truth;
      problem.cameras[camera].pose = moved(truth.cameras[camera].pose, h * Vector6::Unit(k));
      ASSERT_TRUE(adjuster.run(problem, to_the_end, result).ok());
      plus = problem;
      problem = truth;
      problem.cameras[camera].pose = moved(truth.cameras[camera].pose, -h * Vector6::Unit(k));
      ASSERT_TRUE(adjuster.run(problem, to_the_end, result).ok());
      const Eigen::VectorXd difference = -free_difference(plus) / (2 * h);
      const Eigen::VectorXd column = analytic.col(6 * f + k);
      EXPECT_LT((difference - column).norm(), 1e-3 * column.norm()) << "fixed camera " << f << ", parameter " << k;
    }
  }
}

TEST(BundleCovariance, WindowWithHeldScaleFollowsItsFixedCameraAsARigidBody) {
  test::make_window({.fixed = 1, .points = 120}, problem);
  problem.hold = {true, 0, 2};
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, to_the_end, result, &joint).ok());
  ASSERT_TRUE(joint.valid);
  const Matrix analytic = transfer();
  ASSERT_EQ(analytic.cols(), 6);
  const Mat3 origin = rotation_from_quaternion(problem.cameras[0].pose.q_cam_from_world);
  const Eigen::Map<const Vec3> origin_centre(problem.cameras[0].pose.centre);
  for (int i = 0; i < joint.free_count; ++i) {
    // A turn w of the origin in its own axes turns the world by R_o^T exp(-w) R_o about its centre.
    const Pose& pose = problem.cameras[joint.free_camera[static_cast<std::size_t>(i)]].pose;
    const Vec3 arm = Eigen::Map<const Vec3>(pose.centre) - origin_centre;
    Eigen::Matrix<double, 6, 6> rigid = Eigen::Matrix<double, 6, 6>::Zero();
    rigid.topLeftCorner<3, 3>() = rotation_from_quaternion(pose.q_cam_from_world) * origin.transpose();
    rigid.bottomLeftCorner<3, 3>() = cross_matrix(arm) * origin.transpose();
    rigid.bottomRightCorner<3, 3>().setIdentity();
    EXPECT_LT((analytic.middleRows<6>(6 * i) - rigid).norm(), 1e-4) << "camera " << i;
  }
}

TEST(BundleCovariance, ScaleIsTheDerivativeByTheHeldDistance) {
  test::make_window({.fixed = 1, .points = 120}, truth);
  truth.hold = {true, 0, 1};
  problem = truth;
  BundleResult result;
  ASSERT_TRUE(adjuster.run(problem, to_the_end, result, &joint).ok());
  static BundleProblem before;
  before = problem;
  const double h = 1e-4;
  for (int k = 0; k < 3; ++k) {
    double& x = problem.cameras[1].pose.centre[k];
    const double origin = problem.cameras[0].pose.centre[k];
    x = origin + (1 + h) * (x - origin);
  }
  const Eigen::VectorXd scale = Eigen::Map<const Eigen::VectorXd>(joint.scale.data(), 6 * joint.free_count);
  const Matrix sigma = conditional();
  ASSERT_TRUE(adjuster.run(problem, to_the_end, result, &joint).ok());
  const Eigen::VectorXd difference = free_difference(before) / h;
  EXPECT_LT((difference - scale).norm(), 1e-3 * scale.norm());
  // Along the line between the two cameras nothing is uncertain.
  const Vec3 along = scale.segment<3>(3).normalized();
  EXPECT_LT(std::sqrt(along.dot(sigma.block<3, 3>(3, 3) * along)), 1e-5);
}

TEST(BundleCovariance, IsRefusedWhereTheFrameIsNotFixed) {
  BundleResult result;
  for (const int fixed : {0, 1, 5}) {
    test::make_window({.fixed = fixed, .points = 40}, problem);
    ASSERT_TRUE(adjuster.run(problem, {}, result, &joint).ok());
    EXPECT_FALSE(joint.valid) << fixed << " fixed cameras of 5";
    EXPECT_EQ(joint.conditional[0], 0);
  }
}

TEST(BundleCovariance, DoesNotChangeTheAdjustment) {
  test::make_window({.points = 80}, problem);
  truth = problem;
  BundleResult with;
  BundleResult without;
  ASSERT_TRUE(adjuster.run(problem, {}, with, &joint).ok());
  ASSERT_TRUE(adjuster.run(truth, {}, without).ok());
  EXPECT_EQ(with.final_cost, without.final_cost);
  EXPECT_EQ(with.cameras[3].sigma[0], without.cameras[3].sigma[0]);
}

}  // namespace
}  // namespace ilp
