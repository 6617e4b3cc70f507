#include "tests/unit/vision/multiview/bundle/ceres_bundle.hpp"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <ctime>
#include <memory>
#include <vector>

namespace ilp::test {
namespace {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Parameters: angle-axis of cam_from_world, centre.
struct CameraBlock {
  double parameters[6];
  Eigen::Matrix3d rotation;
  Eigen::Matrix3d left;  ///< derivative of a small turn in the camera's axes by the angle-axis
  double fx, fy, cx, cy;
};

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

class Cameras : public ceres::EvaluationCallback {
 public:
  explicit Cameras(std::size_t count) : blocks(count) {}

  void PrepareForEvaluation(bool /*jacobians*/, bool new_point) override {
    if (!new_point) return;
    for (CameraBlock& block : blocks) {
      const Eigen::Map<const Eigen::Vector3d> w(block.parameters);
      const double angle = w.norm();
      const Eigen::Matrix3d k = cross(w);
      block.rotation.setIdentity();
      block.left.setIdentity();
      if (angle < 1e-12) continue;
      const double a2 = angle * angle;
      block.rotation += std::sin(angle) / angle * k + (1 - std::cos(angle)) / a2 * k * k;
      block.left += (1 - std::cos(angle)) / a2 * k + (angle - std::sin(angle)) / (a2 * angle) * k * k;
    }
  }

  std::vector<CameraBlock> blocks;
};

class Reprojection : public ceres::SizedCostFunction<2, 6, 3> {
 public:
  Reprojection(const CameraBlock& camera, const BundleObservation& o) : camera_(camera), x_(o.x), y_(o.y) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> centre(parameters[0] + 3);
    const Eigen::Map<const Eigen::Vector3d> point(parameters[1]);
    const Eigen::Vector3d q = camera_.rotation * (point - centre);
    const double inverse_z = 1 / q.z();
    const double x = q.x() * inverse_z;
    const double y = q.y() * inverse_z;
    residuals[0] = camera_.fx * x + camera_.cx - x_;
    residuals[1] = camera_.fy * y + camera_.cy - y_;
    if (jacobians == nullptr) return q.z() > 0;
    Eigen::Matrix<double, 2, 3> by_q;
    by_q << camera_.fx * inverse_z, 0, -camera_.fx * x * inverse_z, 0, camera_.fy * inverse_z,
        -camera_.fy * y * inverse_z;
    const Eigen::Matrix<double, 2, 3> by_point = by_q * camera_.rotation;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> by_camera(jacobians[0]);
      Eigen::Matrix<double, 2, 3> by_turn;
      by_turn << -camera_.fx * x * y, camera_.fx * (1 + x * x), -camera_.fx * y, -camera_.fy * (1 + y * y),
          camera_.fy * x * y, camera_.fy * x;
      by_camera.leftCols<3>() = by_turn * camera_.left;
      by_camera.rightCols<3>() = -by_point;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> out(jacobians[1]);
      out = by_point;
    }
    return q.z() > 0;
  }

 private:
  const CameraBlock& camera_;
  double x_, y_;
};

CameraBlock block_of(const BundleCamera& camera) {
  const double* q = camera.pose.q_cam_from_world;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
  const Eigen::Vector3d w = turn.angle() * turn.axis();
  const double* c = camera.pose.centre;
  return {{w.x(), w.y(), w.z(), c[0], c[1], c[2]}, {}, {}, camera.fx, camera.fy, camera.cx, camera.cy};
}

}  // namespace

CeresResult adjust_with_ceres(const BundleProblem& problem, const BundleParams& params) {
  Cameras cameras(problem.cameras.size());
  for (std::size_t i = 0; i < cameras.blocks.size(); ++i) cameras.blocks[i] = block_of(problem.cameras[i]);
  std::vector<BundlePoint> points(problem.points.begin(), problem.points.end());

  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &cameras;
  ceres::Problem peer(problem_options);
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (BundlePoint& point : points) {
    peer.AddParameterBlock(point.position, 3);
    ordering->AddElementToGroup(point.position, 0);
  }
  for (std::size_t i = 0; i < cameras.blocks.size(); ++i) {
    double* parameters = cameras.blocks[i].parameters;
    peer.AddParameterBlock(parameters, 6);
    ordering->AddElementToGroup(parameters, 1);
    if (problem.cameras[i].fixed) peer.SetParameterBlockConstant(parameters);
  }
  ceres::LossFunction* loss = nullptr;
  if (params.robust_px > 0) loss = new ceres::CauchyLoss(params.robust_px);
  for (const BundleObservation& o : problem.observations) {
    peer.AddResidualBlock(new Reprojection(cameras.blocks[o.camera], o), loss, cameras.blocks[o.camera].parameters,
                          points[o.point].position);
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering.reset(ordering);
  options.num_threads = 1;
  options.max_num_iterations = static_cast<int>(params.max_iterations);
  options.function_tolerance = params.relative_tolerance;
  // The change of the cost alone decides, as here.
  options.gradient_tolerance = 1e-30;
  options.parameter_tolerance = 1e-30;
  options.initial_trust_region_radius = 1 / LevenbergMarquardt{}.damping;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const std::clock_t begun = std::clock();
  ceres::Solve(options, &peer, &summary);
  const std::clock_t ended = std::clock();

  CeresResult result;
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.solve_s = static_cast<double>(ended - begun) / CLOCKS_PER_SEC;
  for (std::size_t i = 0; i < cameras.blocks.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) result.centres[i][k] = cameras.blocks[i].parameters[3 + k];
  }
  return result;
}

}  // namespace ilp::test
