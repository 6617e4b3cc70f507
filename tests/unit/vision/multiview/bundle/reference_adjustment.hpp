// An independent, slow bundle adjustment to compare with: other parameters (angle-axis and translation, added to),
// central differences instead of analytic derivatives, one sparse system of all unknowns instead of a Schur complement.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <vector>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp::test {

class ReferenceAdjustment {
 public:
  explicit ReferenceAdjustment(const BundleProblem& problem) : problem_(problem) {
    const std::size_t cameras = problem.cameras.size();
    column_.assign(cameras, -1);
    parameters_.resize(static_cast<Eigen::Index>(6 * cameras + 3 * problem.points.size()));
    for (std::size_t i = 0; i < cameras; ++i) {
      const BundleCamera& camera = problem.cameras[i];
      const double* q = camera.pose.q_cam_from_world;
      const Eigen::AngleAxisd turn(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
      const Eigen::Vector3d centre(camera.pose.centre[0], camera.pose.centre[1], camera.pose.centre[2]);
      parameters_.segment<3>(at(i)) = turn.angle() * turn.axis();
      parameters_.segment<3>(at(i) + 3) = -(turn * centre);
      if (!camera.fixed) {
        column_[i] = columns_;
        columns_ += 6;
      }
    }
    point_column_ = columns_;
    columns_ += static_cast<int>(3 * problem.points.size());
    for (std::size_t i = 0; i < problem.points.size(); ++i) {
      const double* x = problem.points[i].position;
      parameters_.segment<3>(point_at(i)) = Eigen::Vector3d(x[0], x[1], x[2]);
    }
  }

  /// Half the sum of squared residuals (Cauchy's function of each observation's norm if `robust` > 0), px^2.
  [[nodiscard]] double cost(double robust = 0) const { return cost(parameters_, robust); }

  /// Levenberg-Marquardt to convergence; returns the minimum.
  double minimise(int iterations, double robust = 0) {
    double lambda = 1e-4;
    double best = cost(robust);
    for (int i = 0; i < iterations; ++i) {
      Eigen::VectorXd gradient;
      Eigen::SparseMatrix<double> normal = normal_equations(robust, gradient);
      for (Eigen::Index k = 0; k < normal.rows(); ++k) normal.coeffRef(k, k) *= 1 + lambda;
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
      const Eigen::VectorXd step = solver.solve(-gradient);
      Eigen::VectorXd trial = parameters_;
      for (std::size_t c = 0; c < column_.size(); ++c) {
        if (column_[c] >= 0) trial.segment<6>(at(c)) += step.segment<6>(column_[c]);
      }
      trial.tail(static_cast<Eigen::Index>(3 * problem_.points.size())) += step.tail(columns_ - point_column_);
      const double value = cost(trial, robust);
      if (value < best) {
        const bool done = best - value < 1e-12 * best;
        best = value;
        parameters_ = trial;
        lambda *= 0.1;
        if (done) break;
      } else {
        lambda *= 10;
        if (lambda > 1e6) break;
      }
    }
    return best;
  }

  [[nodiscard]] Eigen::Vector3d centre(std::size_t camera) const {
    return centre_of(parameters_.segment<6>(at(camera)));
  }

  /// Covariance of the camera centre for unit residual variance, from the full dense inverse and the derivative of the
  /// centre by the camera's parameters.
  [[nodiscard]] Eigen::Matrix3d centre_covariance(std::size_t camera) const {
    Eigen::VectorXd gradient;
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(normal_equations(0, gradient)).inverse();
    const Eigen::Matrix<double, 6, 6> block = inverse.block<6, 6>(column_[camera], column_[camera]);
    Eigen::Matrix<double, 3, 6> derivative;
    const Eigen::Matrix<double, 6, 1> here = parameters_.segment<6>(at(camera));
    for (int k = 0; k < 6; ++k) {
      Eigen::Matrix<double, 6, 1> plus = here;
      Eigen::Matrix<double, 6, 1> minus = here;
      plus[k] += 1e-6;
      minus[k] -= 1e-6;
      derivative.col(k) = (centre_of(plus) - centre_of(minus)) / 2e-6;
    }
    return derivative * block * derivative.transpose();
  }

 private:
  static Eigen::Index at(std::size_t camera) { return static_cast<Eigen::Index>(6 * camera); }
  [[nodiscard]] Eigen::Index point_at(std::size_t point) const {
    return static_cast<Eigen::Index>(6 * problem_.cameras.size() + 3 * point);
  }
  static Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v) {
    return v.norm() > 0 ? Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix()
                        : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  }
  static Eigen::Vector3d centre_of(const Eigen::Matrix<double, 6, 1>& camera) {
    return -(rotation_of(camera.head<3>()).transpose() * camera.tail<3>());
  }
  [[nodiscard]] Eigen::Vector2d residual(const Eigen::Matrix<double, 6, 1>& camera, const Eigen::Vector3d& point,
                                         const BundleObservation& o) const {
    const BundleCamera& lens = problem_.cameras[o.camera];
    const Eigen::Vector3d x = rotation_of(camera.head<3>()) * point + camera.tail<3>();
    return {lens.fx * x.x() / x.z() + lens.cx - o.x, lens.fy * x.y() / x.z() + lens.cy - o.y};
  }
  [[nodiscard]] double cost(const Eigen::VectorXd& parameters, double robust) const {
    double sum = 0;
    for (const BundleObservation& o : problem_.observations) {
      const double squared =
          residual(parameters.segment<6>(at(o.camera)), parameters.segment<3>(point_at(o.point)), o).squaredNorm();
      sum += robust > 0 ? robust * robust * std::log1p(squared / (robust * robust)) : squared;
    }
    return 0.5 * sum;
  }
  Eigen::SparseMatrix<double> normal_equations(double robust, Eigen::VectorXd& gradient) const {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(2 * problem_.observations.size()));
    constexpr double h = 1e-6;
    for (std::size_t i = 0; i < problem_.observations.size(); ++i) {
      const BundleObservation& o = problem_.observations[i];
      const Eigen::Matrix<double, 6, 1> camera = parameters_.segment<6>(at(o.camera));
      const Eigen::Vector3d point = parameters_.segment<3>(point_at(o.point));
      const Eigen::Vector2d r = residual(camera, point, o);
      const double root = robust > 0 ? robust / std::sqrt(robust * robust + r.squaredNorm()) : 1;
      const auto row = static_cast<int>(2 * i);
      residuals.segment<2>(row) = root * r;
      for (int k = 0; k < 6 && column_[o.camera] >= 0; ++k) {
        Eigen::Matrix<double, 6, 1> plus = camera;
        Eigen::Matrix<double, 6, 1> minus = camera;
        plus[k] += h;
        minus[k] -= h;
        const Eigen::Vector2d d = root * (residual(plus, point, o) - residual(minus, point, o)) / (2 * h);
        entries.emplace_back(row, column_[o.camera] + k, d.x());
        entries.emplace_back(row + 1, column_[o.camera] + k, d.y());
      }
      for (int k = 0; k < 3; ++k) {
        Eigen::Vector3d plus = point;
        Eigen::Vector3d minus = point;
        plus[k] += h;
        minus[k] -= h;
        const Eigen::Vector2d d = root * (residual(camera, plus, o) - residual(camera, minus, o)) / (2 * h);
        entries.emplace_back(row, point_column_ + 3 * o.point + k, d.x());
        entries.emplace_back(row + 1, point_column_ + 3 * o.point + k, d.y());
      }
    }
    Eigen::SparseMatrix<double> jacobian(residuals.size(), columns_);
    jacobian.setFromTriplets(entries.begin(), entries.end());
    gradient = jacobian.transpose() * residuals;
    return jacobian.transpose() * jacobian;
  }

  const BundleProblem& problem_;
  std::vector<int> column_;
  int point_column_ = 0;
  int columns_ = 0;
  Eigen::VectorXd parameters_;
};

}  // namespace ilp::test
