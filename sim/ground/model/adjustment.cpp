#include "sim/ground/model/adjustment.hpp"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

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

Matrix rotation_of(const AdjustedCamera& camera) {
  Matrix rotation{};
  for (std::size_t i = 0; i < 9; ++i) rotation[i] = camera.cam_from_world[i];
  return rotation;
}

/// A point in the axes of a camera that has turned by exp([w]x), and its derivative by w.
struct InCamera {
  double point[3] = {};
  Matrix rotation, by_turn{};

  InCamera(const AdjustedCamera& camera, const double* pose, const double* world) {
    const Turn turn(pose);
    rotation = product(turn.rotation, rotation_of(camera));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) point[i] += rotation[3 * i + k] * (world[k] - pose[3 + k]);
    }
    const Matrix turned = product(cross(point), turn.left_jacobian);
    for (std::size_t i = 0; i < 9; ++i) by_turn[i] = -turned[i];
  }
};

/// Camera block: rotation vector w, R = exp([w]x) R0, and centre C. Point block: X. x_cam = R (X - C).
class Reprojection final : public ceres::SizedCostFunction<2, 6, 3> {
 public:
  Reprojection(const AdjustedCamera& camera, const AdjustedObservation& seen) : camera_(camera), seen_(seen) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const InCamera in(camera_, blocks[0], blocks[1]);
    const double(&p)[3] = in.point;
    // A point beside or behind the camera gives no projection: the step is refused.
    if (!(p[2] > 0)) return false;
    residuals[0] = camera_.fx * p[0] / p[2] + camera_.cx - seen_.x;
    residuals[1] = camera_.fy * p[1] / p[2] + camera_.cy - seen_.y;
    if (jacobians == nullptr) return true;
    const double in_camera[2][3] = {{camera_.fx / p[2], 0, -camera_.fx * p[0] / (p[2] * p[2])},
                                    {0, camera_.fy / p[2], -camera_.fy * p[1] / (p[2] * p[2])}};
    for (std::size_t row = 0; row < 2; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        double turned = 0, moved = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          turned += in_camera[row][k] * in.by_turn[3 * k + column];
          moved += in_camera[row][k] * in.rotation[3 * k + column];
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
    const InCamera in(camera_, blocks[0], blocks[1]);
    const double(&p)[3] = in.point;
    const double weight = depth_.inverse_depth / depth_.sigma;
    residuals[0] = weight * p[2] - 1 / depth_.sigma;
    if (jacobians == nullptr) return true;
    for (std::size_t k = 0; k < 3; ++k) {
      if (jacobians[0] != nullptr) {
        jacobians[0][k] = weight * in.by_turn[6 + k];
        jacobians[0][3 + k] = -weight * in.rotation[6 + k];
      }
      if (jacobians[1] != nullptr) jacobians[1][k] = weight * in.rotation[6 + k];
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
  const Matrix rotation = product(turn.rotation, rotation_of(camera));
  for (std::size_t i = 0; i < 9; ++i) camera.cam_from_world[i] = rotation[i];
  for (std::size_t i = 0; i < 3; ++i) camera.centre[i] = block[3 + i];
}

/// The first camera that takes part, and the largest component of the distance to the camera farthest from it.
struct Gauge {
  std::size_t first = 0, anchor = 0;
  int component = 0;
};

Gauge gauge_of(const std::vector<AdjustedCamera>& cameras, const std::vector<std::uint8_t>& takes_part) {
  Gauge gauge;
  while (gauge.first + 1 < cameras.size() && takes_part[gauge.first] == 0) ++gauge.first;
  gauge.anchor = gauge.first;
  double longest = 0;
  for (std::size_t i = gauge.first + 1; i < cameras.size(); ++i) {
    if (takes_part[i] == 0) continue;
    for (int k = 0; k < 3; ++k) {
      const double length = std::fabs(cameras[i].centre[k] - cameras[gauge.first].centre[k]);
      if (length <= longest) continue;
      longest = length;
      gauge.anchor = i;
      gauge.component = k;
    }
  }
  return gauge;
}

std::vector<std::uint8_t> taking_part(const std::vector<AdjustedCamera>& cameras,
                                      const std::vector<AdjustedObservation>& observations) {
  std::vector<std::uint8_t> takes_part(cameras.size(), 0);
  for (const AdjustedObservation& seen : observations) takes_part[seen.camera] = 1;
  return takes_part;
}

PoseBlock block_of(const AdjustedCamera& camera) {
  return {0, 0, 0, camera.centre[0], camera.centre[1], camera.centre[2]};
}

}  // namespace

bool adjust(std::vector<AdjustedCamera>& cameras, std::vector<AdjustedPoint>& points,
            const std::vector<AdjustedObservation>& observations, const std::vector<AdjustedDepth>& depths,
            const AdjustmentParams& params) {
  if (cameras.empty() || observations.empty()) return false;
  std::vector<PoseBlock> blocks(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) blocks[i] = block_of(cameras[i]);
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
  const Gauge gauge = gauge_of(cameras, taking_part(cameras, observations));
  problem.SetParameterBlockConstant(blocks[gauge.first].data());
  if (gauge.anchor != gauge.first) {
    problem.SetManifold(blocks[gauge.anchor].data(), new ceres::SubsetManifold(6, {3 + gauge.component}));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = params.max_iterations;
  options.function_tolerance = 1e-9;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return false;
  for (std::size_t i = 0; i < cameras.size(); ++i) take_back(blocks[i], cameras[i]);
  return true;
}

namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat63 = Eigen::Matrix<double, 6, 3>;

/// The normal equations by cameras and points, each residual in units of its error.
struct NormalEquations {
  std::vector<Mat6> cameras;
  std::vector<Eigen::Matrix3d> points;
  std::vector<std::vector<std::pair<std::uint32_t, Mat63>>> of_point;  ///< by point: camera, mixed part
  double squares = 0;
  std::size_t residuals = 0;

  template <int rows>
  void add(const ceres::CostFunction& cost, const AdjustedCamera& camera, const AdjustedPoint& point,
           std::uint32_t camera_number, std::uint32_t point_number, double weight) {
    Eigen::Matrix<double, rows, 6, Eigen::RowMajor> by_camera;
    Eigen::Matrix<double, rows, 3, Eigen::RowMajor> by_point;
    Eigen::Matrix<double, rows, 1> residual;
    const PoseBlock block = block_of(camera);
    const double* blocks[] = {block.data(), point.position};
    double* jacobians[] = {by_camera.data(), by_point.data()};
    if (!cost.Evaluate(blocks, residual.data(), jacobians)) return;
    cameras[camera_number] += weight * by_camera.transpose() * by_camera;
    points[point_number] += weight * by_point.transpose() * by_point;
    of_point[point_number].emplace_back(camera_number, weight * by_camera.transpose() * by_point);
    squares += weight * residual.squaredNorm();
    residuals += rows;
  }
};

/// Without the points. False where a point is not determined.
bool reduce(const NormalEquations& normal, Eigen::MatrixXd& reduced) {
  const auto side = static_cast<Eigen::Index>(6 * normal.cameras.size());
  reduced = Eigen::MatrixXd::Zero(side, side);
  for (std::size_t c = 0; c < normal.cameras.size(); ++c)
    reduced.block<6, 6>(static_cast<Eigen::Index>(6 * c), static_cast<Eigen::Index>(6 * c)) = normal.cameras[c];
  for (std::size_t p = 0; p < normal.points.size(); ++p) {
    const Eigen::Matrix3d inverse = normal.points[p].inverse();
    if (!inverse.allFinite()) return false;
    for (const auto& [a, mixed_a] : normal.of_point[p]) {
      const Mat63 weighted = mixed_a * inverse;
      for (const auto& [b, mixed_b] : normal.of_point[p])
        reduced.block<6, 6>(Eigen::Index{6} * a, Eigen::Index{6} * b) -= weighted * mixed_b.transpose();
    }
  }
  return true;
}

}  // namespace

std::vector<PoseCovariance> pose_covariances(const std::vector<AdjustedCamera>& cameras,
                                             const std::vector<AdjustedPoint>& points,
                                             const std::vector<AdjustedObservation>& observations,
                                             const std::vector<AdjustedDepth>& depths) {
  if (cameras.size() < 2 || cameras.size() > max_cameras_with_errors) return {};
  NormalEquations normal;
  normal.cameras.assign(cameras.size(), Mat6::Zero());
  normal.points.assign(points.size(), Eigen::Matrix3d::Zero());
  normal.of_point.resize(points.size());
  for (const AdjustedObservation& seen : observations) {
    normal.add<2>(Reprojection(cameras[seen.camera], seen), cameras[seen.camera], points[seen.point], seen.camera,
                  seen.point, 1);
  }
  const double unknowns = 3.0 * static_cast<double>(points.size()) + 6.0 * static_cast<double>(cameras.size());
  const double freedom = static_cast<double>(normal.residuals + depths.size()) - unknowns;
  if (!(freedom > 0)) return {};
  const double variance = normal.squares / freedom;
  // Depths are in units of their errors already, and pixels are not.
  for (const AdjustedDepth& depth : depths) {
    normal.add<1>(DepthPrior(cameras[depth.camera], depth), cameras[depth.camera], points[depth.point], depth.camera,
                  depth.point, variance);
  }
  Eigen::MatrixXd reduced;
  if (!reduce(normal, reduced)) return {};
  const Gauge gauge = gauge_of(cameras, taking_part(cameras, observations));
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < 6 * cameras.size(); ++i) {
    const bool held = i / 6 == gauge.first || i == 6 * gauge.anchor + 3 + static_cast<std::size_t>(gauge.component);
    if (!held) free.push_back(static_cast<Eigen::Index>(i));
  }
  const Eigen::MatrixXd information = reduced(free, free);
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  if (factor.info() != Eigen::Success) return {};
  const auto side = static_cast<Eigen::Index>(free.size());
  const Eigen::MatrixXd inverse = variance * factor.solve(Eigen::MatrixXd::Identity(side, side));
  std::vector<Eigen::Index> place(6 * cameras.size(), -1);
  for (std::size_t i = 0; i < free.size(); ++i) place[static_cast<std::size_t>(free[i])] = static_cast<Eigen::Index>(i);
  std::vector<PoseCovariance> errors(cameras.size(), PoseCovariance{});
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (std::size_t row = 0, k = 0; row < 6; ++row) {
      for (std::size_t column = 0; column <= row; ++column, ++k) {
        const Eigen::Index i = place[6 * c + row], j = place[6 * c + column];
        if (i >= 0 && j >= 0) errors[c][k] = inverse(i, j);
      }
    }
  }
  return errors;
}

}  // namespace ilp::model
