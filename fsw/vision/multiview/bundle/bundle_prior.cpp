// Priors of a bundle adjustment: residuals that belong to one camera.
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/bundle_equations.hpp"

namespace ilp::bundle {
namespace {

bool is_unit(const double* v, int size) {
  double norm2 = 0;
  for (int i = 0; i < size; ++i) norm2 += v[i] * v[i];
  return std::fabs(norm2 - 1) < 1e-6;  // false for NaN and infinity
}

bool is_sigma(double sigma) {
  return sigma > 0 && std::isfinite(sigma);
}

double height_residual(const BundleHeightPrior& prior, const Camera& camera) {
  double along = 0;
  for (int k = 0; k < 3; ++k) along += prior.direction[k] * camera.centre[k];
  return (along - prior.value) / prior.sigma;
}

/// Rotation vector from the prior's attitude to the camera's.
Vec3 turn_from_prior(const BundleAttitudePrior& prior, const Camera& camera) {
  Mat3 rotation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = camera.rotation[i];
  return vector_from_rotation(rotation * rotation_from_quaternion(prior.q_cam_from_world).transpose());
}

/// Derivative of log(exp(w) exp(v)) by w at w = 0: the inverse of the left Jacobian (T. D. Barfoot, State Estimation
/// for Robotics, 2017, section 7.1.5).
Mat3 inverse_left_jacobian(const Vec3& v) {
  const Mat3 k = cross_matrix(v);
  const double angle2 = v.squaredNorm();
  double factor = 1.0 / 12;
  if (angle2 > 1e-6) {
    const double angle = std::sqrt(angle2);
    factor = 1 / angle2 - (1 + det_cos(angle)) / (2 * angle * det_sin(angle));
  }
  return Mat3::Identity() - 0.5 * k + factor * k * k;
}

}  // namespace

Status check_priors(const BundleProblem& problem) {
  for (std::size_t i = 0; i < problem.heights.size(); ++i) {
    const BundleHeightPrior& prior = problem.heights[i];
    if (prior.camera >= problem.cameras.size() || !is_unit(prior.direction, 3) || !std::isfinite(prior.value) ||
        !is_sigma(prior.sigma)) {
      return out_of_range(Argument::height_prior, i);
    }
  }
  for (std::size_t i = 0; i < problem.attitudes.size(); ++i) {
    const BundleAttitudePrior& prior = problem.attitudes[i];
    if (prior.camera >= problem.cameras.size() || !is_unit(prior.q_cam_from_world, 4) ||
        !is_sigma(prior.sigma_rad[0]) || !is_sigma(prior.sigma_rad[1]) || !is_sigma(prior.sigma_rad[2])) {
      return out_of_range(Argument::attitude_prior, i);
    }
  }
  return {};
}

double prior_cost(const Equations& eq, const Cameras& cameras) {
  double squared = 0;
  for (const BundleHeightPrior& prior : eq.problem->heights) {
    const double residual = height_residual(prior, cameras[prior.camera]);
    squared += residual * residual;
  }
  for (const BundleAttitudePrior& prior : eq.problem->attitudes) {
    const Vec3 turn = turn_from_prior(prior, cameras[prior.camera]);
    for (int k = 0; k < 3; ++k) squared += (turn[k] / prior.sigma_rad[k]) * (turn[k] / prior.sigma_rad[k]);
  }
  return eq.params.observation_sigma_px * eq.params.observation_sigma_px * squared;
}

void add_priors(Equations& eq) {
  const double weight = eq.params.observation_sigma_px * eq.params.observation_sigma_px;
  for (std::size_t k = 0; k < 36 * eq.free_count; ++k) eq.prior_blocks[k] = 0;
  const auto add = [&](std::size_t block, const double derivative[6], double residual) {
    for (std::size_t r = 0; r < camera_size; ++r) {
      eq.reduced_gradient[camera_size * block + r] += weight * derivative[r] * residual;
      eq.diagonal[camera_size * block + r] += weight * derivative[r] * derivative[r];
      for (std::size_t c = 0; c < camera_size; ++c) {
        eq.prior_blocks[36 * block + camera_size * r + c] += derivative[r] * derivative[c];
      }
    }
  };
  for (const BundleHeightPrior& prior : eq.problem->heights) {
    const Camera& camera = eq.cameras[prior.camera];
    if (!camera.free) continue;
    double derivative[6] = {0, 0, 0, 0, 0, 0};
    for (int k = 0; k < 3; ++k) derivative[3 + k] = prior.direction[k] / prior.sigma;
    add(camera.block, derivative, height_residual(prior, camera));
  }
  for (const BundleAttitudePrior& prior : eq.problem->attitudes) {
    const Camera& camera = eq.cameras[prior.camera];
    if (!camera.free) continue;
    const Vec3 turn = turn_from_prior(prior, camera);
    const Mat3 by_turn = inverse_left_jacobian(turn);
    for (int row = 0; row < 3; ++row) {
      double derivative[6] = {0, 0, 0, 0, 0, 0};
      for (int k = 0; k < 3; ++k) derivative[k] = by_turn(row, k) / prior.sigma_rad[row];
      add(camera.block, derivative, turn[row] / prior.sigma_rad[row]);
    }
  }
}

void multiply_priors(const Equations& eq, const double* x, double* y) {
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    for (std::size_t r = 0; r < camera_size; ++r) {
      double sum = 0;
      for (std::size_t c = 0; c < camera_size; ++c) {
        sum += eq.prior_blocks[36 * a + camera_size * r + c] * x[camera_size * a + c];
      }
      y[camera_size * a + r] = sum;
    }
  }
}

}  // namespace ilp::bundle
