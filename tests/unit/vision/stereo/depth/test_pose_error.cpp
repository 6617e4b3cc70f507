// What an error of the poses does to depth, against the depth of the same match with poses that were moved.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fsw/vision/multiview/sequence_covariance.hpp"
#include "fsw/vision/stereo/depth/pose_error.hpp"

namespace ilp {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

Vec2 seen_by(const RigidTransform& camera, const Vec3& point) {
  const Vec3 q = camera * point;
  return {q.x() / q.z(), q.y() / q.z()};
}

/// Depth at which the ray comes nearest to `match` in the second image: a search, without derivatives.
double depth_of_match(const RigidTransform& second_from_first, const Vec2& direction, const Vec2& match, double near,
                      double far) {
  const auto miss = [&](double depth) {
    return (seen_by(second_from_first, depth * Vec3(direction.x(), direction.y(), 1)) - match).squaredNorm();
  };
  for (int i = 0; i < 200; ++i) {
    const double a = near + (far - near) / 3;
    const double b = far - (far - near) / 3;
    (miss(a) < miss(b) ? far : near) = miss(a) < miss(b) ? b : a;
  }
  return 0.5 * (near + far);
}

/// The step with an error: exp(rotation) R, and another place of the second camera in the first one's axes.
RigidTransform moved(const RigidTransform& step, const Vec6& error) {
  const Vec3 place = -(step.rotation.transpose() * step.translation) + error.tail<3>();
  const Mat3 rotation = rotation_from_vector(error.head<3>()) * step.rotation;
  return {rotation, -(rotation * place)};
}

RigidTransform step_to(const Vec3& place, const Vec3& turn) {
  const Mat3 rotation = rotation_from_vector(turn);
  return {rotation, -(rotation * place)};
}

StepCovariance covariance_along(const Vec6& error) {
  StepCovariance covariance;
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) covariance.lower[k] = error[row] * error[column];
  }
  covariance.lower[20] = std::max(covariance.lower[20], 1e-30);
  return covariance;
}

TEST(PoseError, IsTheChangeOfDepthThatAMovedPoseMakes) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  for (const Vec3& place : {Vec3(0, 0, 12), Vec3(20, 1, 0), Vec3(5, -3, -10)}) {
    const RigidTransform step = step_to(place, {0.02, -0.03, 0.1});
    for (const Vec2& direction : {Vec2(0.4, 0.1), Vec2(-0.2, 0.3), Vec2(0.1, -0.35)}) {
      const Vec2 match = seen_by(step, 100 * Vec3(direction.x(), direction.y(), 1));
      for (int trial = 0; trial < 5; ++trial) {
        Vec6 error;
        for (int i = 0; i < 6; ++i) error[i] = (i < 3 ? 1e-5 : 1e-3) * normal(random);
        const double depth = depth_of_match(moved(step, error), direction, match, 80, 125);
        const double stated = depth_error_of_poses(step, covariance_along(error), direction, 100);
        EXPECT_NEAR(std::fabs(depth / 100 - 1), stated, 0.02 * stated + 1e-6);
      }
    }
  }
}

TEST(PoseError, GrowsTowardsTheEpipoleAndIsNothingWithoutCovariance) {
  const RigidTransform step = step_to({0, 0, 12}, Vec3::Zero());
  Vec6 error;
  error << 0, 0, 0, 0, 0, 0.12;
  const StepCovariance covariance = covariance_along(error);
  // A baseline that is 1 % too long makes every depth 1 % too large, less what the point itself is nearer.
  EXPECT_NEAR(depth_error_of_poses(step, covariance, {0.3, 0}, 100), 0.01, 0.001);
  Vec6 aside;
  aside << 0, 0, 0, 0.12, 0, 0;
  EXPECT_GT(depth_error_of_poses(step, covariance_along(aside), {0.02, 0}, 100),
            5 * depth_error_of_poses(step, covariance_along(aside), {0.3, 0}, 100));
  EXPECT_EQ(depth_error_of_poses(step, {}, {0.3, 0}, 100), 0);
  EXPECT_EQ(depth_error_of_poses(step_to({0, 0, 120}, Vec3::Zero()), covariance, {0.3, 0}, 100), 0);
}

TEST(PoseError, TheStepHasTheErrorsThatTwoCamerasHaveTogether) {
  std::mt19937 random(8);
  std::normal_distribution<double> normal(0, 1);
  const RigidTransform a = step_to({1, 2, 3}, {0.1, 3.0, 0.2});
  const RigidTransform b = step_to({1.5, 2.2, 1.8}, {0.2, 2.9, 0.1});
  constexpr int size = static_cast<int>(StripCovariance::size);
  StripCovariance strip{.known = 7};
  // A joint covariance of three cameras, that of a and b fully correlated with each other.
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(18, 18);
  for (int i = 6; i < 18; ++i) {
    for (int k = 0; k < 18; ++k) root(i, k) = 1e-4 * normal(random);
  }
  const Eigen::MatrixXd joint = root * root.transpose();
  for (int i = 0; i < 18; ++i) {
    for (int k = 0; k < 18; ++k) strip.matrix[static_cast<std::size_t>(i * size + k)] = joint(i, k);
  }
  double lower[21];
  covariance_of_step(strip, 2, a, b, lower);

  // The same from the two cameras moved by each column of the root.
  const auto camera_moved = [](const RigidTransform& camera, const Eigen::VectorXd& error) {
    const Vec3 centre = -(camera.rotation.transpose() * camera.translation) + Vec3(error.tail<3>());
    const Mat3 rotation = rotation_from_vector(Vec3(error.head<3>())) * camera.rotation;
    return RigidTransform{rotation, -(rotation * centre)};
  };
  const RigidTransform step = compose(b, inverse(a));
  Eigen::Matrix<double, 6, 6> expected = Eigen::Matrix<double, 6, 6>::Zero();
  for (int k = 0; k < 18; ++k) {
    const RigidTransform with_error =
        compose(camera_moved(b, root.col(k).segment(12, 6)), inverse(camera_moved(a, root.col(k).segment(6, 6))));
    Vec6 error;
    error.head<3>() = vector_from_rotation(with_error.rotation * step.rotation.transpose());
    error.tail<3>() =
        step.rotation.transpose() * step.translation - with_error.rotation.transpose() * with_error.translation;
    expected += error * error.transpose();
  }
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) {
      EXPECT_NEAR(lower[k], expected(row, column), 0.01 * std::sqrt(expected(row, row) * expected(column, column)));
    }
  }
  covariance_of_step(strip, 0, a, b, lower);
  EXPECT_EQ(lower[20], 0);
  strip.known = 5;
  covariance_of_step(strip, 2, a, b, lower);
  EXPECT_EQ(lower[20], 0);
}

TEST(PoseError, TwoStepsThatAreIndependentHaveTheErrorsOfBoth) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  const RigidTransform first = step_to({20, -3, 5}, {0.1, -0.2, 0.3});
  const RigidTransform second = step_to({15, 6, -8}, {-0.2, 0.1, 0.4});
  const auto root_of_six = [&] {
    Eigen::Matrix<double, 6, 6> root;
    for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = 1e-4 * normal(random);
    return root;
  };
  const auto lower_of = [](const Eigen::Matrix<double, 6, 6>& full) {
    StepCovariance covariance;
    for (int row = 0, k = 0; row < 6; ++row) {
      for (int column = 0; column <= row; ++column, ++k) covariance.lower[k] = full(row, column);
    }
    return covariance;
  };
  const Eigen::Matrix<double, 6, 6> a = root_of_six(), b = root_of_six();
  const StepCovariance joined = joined_steps(first, lower_of(a * a.transpose()), second, lower_of(b * b.transpose()));
  // The same from steps that are moved by each column of the roots.
  const RigidTransform both = compose(second, first);
  Eigen::Matrix<double, 6, 6> expected = Eigen::Matrix<double, 6, 6>::Zero();
  for (int k = 0; k < 12; ++k) {
    const RigidTransform with_error =
        k < 6 ? compose(second, moved(first, Vec6(a.col(k)))) : compose(moved(second, Vec6(b.col(k - 6))), first);
    Vec6 error;
    error.head<3>() = vector_from_rotation(with_error.rotation * both.rotation.transpose());
    error.tail<3>() =
        both.rotation.transpose() * both.translation - with_error.rotation.transpose() * with_error.translation;
    expected += error * error.transpose();
  }
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) {
      EXPECT_NEAR(joined.lower[k], expected(row, column),
                  0.01 * std::sqrt(expected(row, row) * expected(column, column)));
    }
  }
  EXPECT_FALSE(joined_steps(first, {}, second, joined).known());
  EXPECT_FALSE(joined_steps(first, joined, second, {}).known());
}

}  // namespace
}  // namespace ilp
