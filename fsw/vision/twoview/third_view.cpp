#include "fsw/vision/twoview/third_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/twoview/refine/homography_refinement.hpp"
#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/refine/normal_equations.hpp"
#include "fsw/vision/twoview/robust/homography_problem.hpp"
#include "fsw/vision/twoview/robust/robust_models.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/solvers/homography.hpp"

namespace ilp {
namespace {

constexpr double min_log_odds = 5;         // 150 to one
constexpr double max_excess_share = 0.25;  // of the other's: the chosen plane must itself fit
constexpr double least_variance = 1e-6;    // px^2; rounding errors of exact matches

/// Camera c over a known plane: transfer errors of (R + t plane^T) x_a - x_c.
struct PlanePoseProblem {
  using State = RigidTransform;
  static constexpr int dof = 6;
  using Step = Eigen::Matrix<double, dof, 1>;

  const NormalisedPairs& pairs;
  const Vec3& plane;

  static Mat3 homography(const State& pose, const Vec3& plane) {
    return pose.rotation + pose.translation * plane.transpose();
  }

  void linearise(const State& pose, NormalEquations<dof>& equations) const {
    equations = {};
    const Mat3 h = homography(pose, plane);
    for (const NormalisedPair& pair : pairs.exact) {
      const Vec3 a = pair.ray_a();
      const Vec3 y = h * a;
      const Vec2 projected = y.head<2>() / y.z();
      const Vec2 residual((projected.x() - pair.xb) * pairs.scale.bx, (projected.y() - pair.yb) * pairs.scale.by);
      Eigen::Matrix<double, 2, 3> by_point;
      by_point << pairs.scale.bx / y.z(), 0, -projected.x() * pairs.scale.bx / y.z(),  //
          0, pairs.scale.by / y.z(), -projected.y() * pairs.scale.by / y.z();
      Eigen::Matrix<double, 2, dof> jacobian;
      for (int k = 0; k < 3; ++k) jacobian.col(k) = by_point * (pose.rotation * Vec3::Unit(k).cross(a));
      jacobian.rightCols<3>() = plane.dot(a) * by_point;
      equations.hessian += jacobian.transpose() * jacobian;
      equations.gradient += jacobian.transpose() * residual;
      equations.cost += residual.squaredNorm();
    }
  }

  double cost(const State& pose) const {
    const Mat3 h = homography(pose, plane);
    double sum = 0;
    for (const NormalisedPair& pair : pairs.exact) sum += transfer_squared(h, pair, pairs.scale);
    return sum;
  }

  State moved(const State& pose, const Step& step) const {
    return {pose.rotation * rotation_from_vector(step.head<3>()), pose.translation + step.tail<3>()};
  }
};

/// Least sum of squared errors of `pairs` over `plane`, px^2, among the motions that their homography allows, and the
/// motion that has it.
double fit_over_plane(const NormalisedPairs& pairs, const Vec3& plane, const PlaneMotion* starts, std::size_t count,
                      RigidTransform& motion) {
  constexpr std::uint32_t steps = 50;
  double best = std::numeric_limits<double>::infinity();
  const PlanePoseProblem problem{pairs, plane};
  for (std::size_t i = 0; i < count; ++i) {
    const double scale = starts[i].plane.dot(plane) / plane.squaredNorm();
    if (!(scale > 0)) continue;
    RigidTransform pose = starts[i].b_from_a;
    pose.translation *= scale;
    if (!std::isfinite(problem.cost(pose))) continue;
    minimise(problem, pose, steps, 1e-8);
    const double cost = problem.cost(pose);
    if (!(cost < best)) continue;
    best = cost;
    motion = pose;
  }
  return best;
}

double sum_of_transfer_errors(const NormalisedPairs& pairs, const Mat3& homography) {
  double sum = 0;
  for (const NormalisedPair& pair : pairs.exact) sum += transfer_squared(homography, pair, pairs.scale);
  return sum;
}

}  // namespace

Status choose_by_third_view(const PlaneSolutions& solutions, const PointPairs& pairs, const CameraModel& camera_a,
                            const CameraModel& camera_c, const RansacParams& params, TwoViewWorkspace& workspace,
                            ThirdViewChoice& choice) {
  choice = {};
  ILP_TRY(validate(camera_a));
  ILP_TRY(validate(camera_c));
  ILP_TRY(validate(params));
  if (solutions.count != 2) return {};
  normalise_pairs(pairs, intrinsics_of(camera_a), intrinsics_of(camera_c), params.seed, workspace.pairs);
  Mat3 free;
  if (!find_homography(workspace.pairs, params, workspace.selected, free)) return {};
  select_homography_inliers(workspace.pairs, free, 2 * params.threshold_px, workspace.selected);
  constexpr std::size_t free_parameters = 8;
  const std::size_t matches = workspace.selected.size();
  if (matches < params.min_inliers || matches <= free_parameters / 2) return {};
  choice.matches = static_cast<std::uint32_t>(matches);
  NormalisedPairs& on_plane = workspace.subset;
  select_subset(workspace.pairs, workspace.selected, on_plane);
  // All costs are of the same matches without weights, so that they can be compared.
  for (std::size_t i = 0; i < matches; ++i) workspace.selected[i] = static_cast<std::uint16_t>(i);
  const RefinementParams all_matches{RobustLoss::truncated, 1e6, 20, 1e-10};
  refine_homography(on_plane, {workspace.selected.data(), matches}, all_matches, free);
  PlaneMotion starts[4];
  const std::size_t start_count = decompose_homography(free, starts);
  if (start_count == 0) return {};

  const double least = sum_of_transfer_errors(on_plane, free);
  for (std::size_t k = 0; k < 2; ++k) {
    const double cost =
        fit_over_plane(on_plane, solutions.solution[k].motion.plane, starts, start_count, choice.c_from_a[k]);
    choice.excess_px2[k] = std::fmax(0.0, cost - least);
  }
  choice.chosen = choice.excess_px2[1] < choice.excess_px2[0] ? 1 : 0;
  const double better = choice.excess_px2[choice.chosen];
  const double worse = choice.excess_px2[1 - choice.chosen];
  if (!std::isfinite(better)) return {};
  const double variance = std::fmax(least_variance, least / static_cast<double>(2 * matches - free_parameters));
  choice.log_odds = 0.5 * (worse - better) / variance;
  choice.decided = choice.log_odds > min_log_odds && better < max_excess_share * worse;
  return {};
}

}  // namespace ilp
