#include "sim/ground/model/adjustment.hpp"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <array>
#include <cmath>

namespace ilp::model {
namespace {

using Matrix = std::array<double, 9>;  // 3 x 3, row-major

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
    }
  }
  return c;
}

Matrix cross(const double* v) {
  return {0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0};
}

/// I + a [w]x + b [w]x^2: the rotation exp([w]x) and its left Jacobian have this form.
Matrix series(const Matrix& w, const Matrix& w2, double a, double b) {
  Matrix out{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 9; ++i) out[i] += a * w[i] + b * w2[i];
  return out;
}

struct Turn {
  Matrix rotation, left_jacobian;

  explicit Turn(const double* w) {
    const double angle2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], angle = std::sqrt(angle2);
    const Matrix x = cross(w), x2 = product(x, x);
    if (angle < 1e-4) {
      rotation = series(x, x2, 1 - angle2 / 6, 0.5 - angle2 / 24);
      left_jacobian = series(x, x2, 0.5 - angle2 / 24, 1.0 / 6 - angle2 / 120);
    } else {
      const double s = std::sin(angle), c = std::cos(angle);
      rotation = series(x, x2, s / angle, (1 - c) / angle2);
      left_jacobian = series(x, x2, (1 - c) / angle2, (angle - s) / (angle2 * angle));
    }
  }
};

/// Camera block: rotation vector w, R = exp([w]x) R0, and centre C. Point block: X. x_cam = R (X - C).
class Reprojection final : public ceres::SizedCostFunction<2, 6, 3> {
 public:
  Reprojection(const AdjustedCamera& camera, const AdjustedObservation& seen) : camera_(camera), seen_(seen) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const double *pose = blocks[0], *point = blocks[1];
    const Turn turn(pose);
    Matrix start{};
    for (std::size_t i = 0; i < 9; ++i) start[i] = camera_.cam_from_world[i];
    const Matrix rotation = product(turn.rotation, start);
    double p[3];
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = 0;
      for (std::size_t k = 0; k < 3; ++k) p[i] += rotation[3 * i + k] * (point[k] - pose[3 + k]);
    }
    // A point beside or behind the camera gives no projection: the step is refused.
    if (!(p[2] > 0)) return false;
    residuals[0] = camera_.fx * p[0] / p[2] + camera_.cx - seen_.x;
    residuals[1] = camera_.fy * p[1] / p[2] + camera_.cy - seen_.y;
    if (jacobians == nullptr) return true;
    const double in_camera[2][3] = {{camera_.fx / p[2], 0, -camera_.fx * p[0] / (p[2] * p[2])},
                                    {0, camera_.fy / p[2], -camera_.fy * p[1] / (p[2] * p[2])}};
    Matrix by_turn = product(cross(p), turn.left_jacobian);  // with the sign changed
    for (std::size_t row = 0; row < 2; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        double turned = 0, moved = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          turned -= in_camera[row][k] * by_turn[3 * k + column];
          moved += in_camera[row][k] * rotation[3 * k + column];
        }
        if (jacobians[0] != nullptr) {
          jacobians[0][6 * row + column] = turned;
          jacobians[0][6 * row + 3 + column] = -moved;
        }
        if (jacobians[1] != nullptr) jacobians[1][3 * row + column] = moved;
      }
    }
    return true;
  }

 private:
  AdjustedCamera camera_;
  AdjustedObservation seen_;
};

/// Blocks as above. The residual is (depth * inverse depth - 1) / sigma.
class DepthPrior final : public ceres::SizedCostFunction<1, 6, 3> {
 public:
  DepthPrior(const AdjustedCamera& camera, const AdjustedDepth& depth) : camera_(camera), depth_(depth) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const double *pose = blocks[0], *point = blocks[1];
    const Turn turn(pose);
    Matrix start{};
    for (std::size_t i = 0; i < 9; ++i) start[i] = camera_.cam_from_world[i];
    const Matrix rotation = product(turn.rotation, start);
    double p[3];
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = 0;
      for (std::size_t k = 0; k < 3; ++k) p[i] += rotation[3 * i + k] * (point[k] - pose[3 + k]);
    }
    const double weight = depth_.inverse_depth / depth_.sigma;
    residuals[0] = weight * p[2] - 1 / depth_.sigma;
    if (jacobians == nullptr) return true;
    const Matrix by_turn = product(cross(p), turn.left_jacobian);  // with the sign changed
    for (std::size_t k = 0; k < 3; ++k) {
      if (jacobians[0] != nullptr) {
        jacobians[0][k] = -weight * by_turn[6 + k];
        jacobians[0][3 + k] = -weight * rotation[6 + k];
      }
      if (jacobians[1] != nullptr) jacobians[1][k] = weight * rotation[6 + k];
    }
    return true;
  }

 private:
  AdjustedCamera camera_;
  AdjustedDepth depth_;
};

using PoseBlock = std::array<double, 6>;

void take_back(const PoseBlock& block, AdjustedCamera& camera) {
  const Turn turn(block.data());
  Matrix start{};
  for (std::size_t i = 0; i < 9; ++i) start[i] = camera.cam_from_world[i];
  const Matrix rotation = product(turn.rotation, start);
  for (std::size_t i = 0; i < 9; ++i) camera.cam_from_world[i] = rotation[i];
  for (std::size_t i = 0; i < 3; ++i) camera.centre[i] = block[3 + i];
}

/// The first camera, and the largest component of the distance to the camera farthest from it.
void hold_gauge(const std::vector<AdjustedCamera>& cameras, ceres::Problem& problem, std::vector<PoseBlock>& blocks) {
  std::size_t first = 0;
  while (first < blocks.size() && !problem.HasParameterBlock(blocks[first].data())) ++first;
  if (first == blocks.size()) return;
  problem.SetParameterBlockConstant(blocks[first].data());
  std::size_t anchor = first;
  int component = 0;
  double longest = 0;
  for (std::size_t i = first + 1; i < cameras.size(); ++i) {
    if (!problem.HasParameterBlock(blocks[i].data())) continue;
    for (int k = 0; k < 3; ++k) {
      const double length = std::fabs(cameras[i].centre[k] - cameras[first].centre[k]);
      if (length <= longest) continue;
      longest = length;
      anchor = i;
      component = k;
    }
  }
  if (anchor != first) problem.SetManifold(blocks[anchor].data(), new ceres::SubsetManifold(6, {3 + component}));
}

}  // namespace

AdjustmentSummary adjust(std::vector<AdjustedCamera>& cameras, std::vector<AdjustedPoint>& points,
                         const std::vector<AdjustedObservation>& observations, const std::vector<AdjustedDepth>& depths,
                         const AdjustmentParams& params) {
  if (cameras.empty() || observations.empty()) return {};
  std::vector<PoseBlock> blocks(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    blocks[i] = {0, 0, 0, cameras[i].centre[0], cameras[i].centre[1], cameras[i].centre[2]};
  }
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  ceres::CauchyLoss loss(params.robust_px);
  for (const AdjustedObservation& seen : observations) {
    problem.AddResidualBlock(new Reprojection(cameras[seen.camera], seen), &loss, blocks[seen.camera].data(),
                             points[seen.point].position);
  }
  for (const AdjustedDepth& depth : depths) {
    problem.AddResidualBlock(new DepthPrior(cameras[depth.camera], depth), nullptr, blocks[depth.camera].data(),
                             points[depth.point].position);
  }
  hold_gauge(cameras, problem, blocks);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = params.max_iterations;
  options.function_tolerance = 1e-9;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  AdjustmentSummary result{summary.IsSolutionUsable(), summary.initial_cost, summary.final_cost,
                           static_cast<int>(summary.iterations.size())};
  if (!result.usable) return result;
  for (std::size_t i = 0; i < cameras.size(); ++i) take_back(blocks[i], cameras[i]);
  return result;
}

}  // namespace ilp::model
