// The best pose that the matches of a pair allow: least squares that start from the truth.
#pragma once

#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"

namespace ilp::test {

struct LeastSquares {
  RigidTransform pose;
  double cost = 0;  ///< px^2
};

/// The minimum of Sampson's distances of the true inliers that is reached from `start`.
inline LeastSquares least_squares_of_inliers(const PoseCase& pose_case, const RigidTransform& start,
                                             TwoViewWorkspace& workspace) {
  NormalisedPairs& pairs = workspace.pairs;
  const ImageNormalisation intrinsics = intrinsics_of(pose_case.camera);
  normalise_pairs(pose_case.pairs, intrinsics, intrinsics, 1, pairs);
  workspace.selected.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pose_case.inlier[pairs.source[i]] == 0) continue;
    static_cast<void>(workspace.selected.push_back(static_cast<std::uint16_t>(i)));
  }
  const PairSelection selection{workspace.selected.data(), workspace.selected.size()};
  LeastSquares result{start};
  const RefinementParams params{RobustLoss::truncated, 1e3, 50, 1e-10};
  refine_relative_pose(pairs, selection, params, result.pose);
  result.cost = epipolar_cost(pairs, selection, params, result.pose);
  return result;
}

/// A bound that no estimate in flight can reach.
inline RigidTransform least_squares_from_truth(const PoseCase& pose_case, TwoViewWorkspace& workspace) {
  return least_squares_of_inliers(pose_case, pose_case.truth, workspace).pose;
}

}  // namespace ilp::test
