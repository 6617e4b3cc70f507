#include "tests/unit/ground/model/ceres_adjustment.hpp"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

namespace ilp::model::test {
namespace {

/// Block of a camera: angle and axis of a turn after its attitude, and centre.
template <typename T>
void in_camera(const PeerCamera& camera, const T* block, const T* point, T* p) {
  T between[3], turned[3] = {T(0), T(0), T(0)};
  for (int i = 0; i < 3; ++i) between[i] = point[i] - block[3 + i];
  for (std::size_t i = 0; i < 9; ++i) turned[i / 3] += camera.cam_from_world[i] * between[i % 3];
  ceres::AngleAxisRotatePoint(block, turned, p);
}

struct Reprojection {
  PeerCamera camera;
  PeerObservation seen;

  template <typename T>
  bool operator()(const T* block, const T* point, T* residual) const {
    T p[3];
    in_camera(camera, block, point, p);
    residual[0] = camera.fx * p[0] / p[2] + camera.cx - seen.x;
    residual[1] = camera.fy * p[1] / p[2] + camera.cy - seen.y;
    return true;
  }
};

struct DepthResidual {
  PeerCamera camera;
  PeerDepth depth;

  template <typename T>
  bool operator()(const T* block, const T* point, T* residual) const {
    T p[3];
    in_camera(camera, block, point, p);
    residual[0] = (depth.inverse_depth * p[2] - 1.0) / depth.sigma;
    return true;
  }
};

}  // namespace

double adjust_with_ceres(PeerProblem& problem, double robust_px) {
  std::vector<std::array<double, 6>> blocks;
  for (const PeerCamera& camera : problem.cameras)
    blocks.push_back({0, 0, 0, camera.centre[0], camera.centre[1], camera.centre[2]});
  ceres::Problem peer;
  for (const PeerObservation& seen : problem.observations) {
    peer.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Reprojection, 2, 6, 3>(new Reprojection{problem.cameras[seen.camera], seen}),
        new ceres::CauchyLoss(robust_px), blocks[seen.camera].data(), problem.points[seen.point].data());
  }
  for (const PeerDepth& depth : problem.depths) {
    peer.AddResidualBlock(new ceres::AutoDiffCostFunction<DepthResidual, 1, 6, 3>(
                              new DepthResidual{problem.cameras[depth.camera], depth}),
                          nullptr, blocks[depth.camera].data(), problem.points[depth.point].data());
  }
  peer.SetParameterBlockConstant(blocks[0].data());
  peer.SetManifold(blocks[problem.anchor].data(), new ceres::SubsetManifold(6, {3 + problem.component}));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &peer, &summary);
  for (std::size_t c = 0; c < blocks.size(); ++c) std::copy_n(&blocks[c][3], 3, problem.cameras[c].centre.begin());
  return summary.final_cost;
}

}  // namespace ilp::model::test
