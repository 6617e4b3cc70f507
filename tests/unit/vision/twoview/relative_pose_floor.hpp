// What the matches of a pair allow at best: least squares by someone who knows the truth.
#pragma once

#include "fsw/vision/twoview/epipolar_refinement.hpp"
#include "fsw/vision/twoview/two_view_workspace.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"

namespace ilp::test {

/// Least squares on Sampson's distance of the true inliers, from the true pose. Leaves them in `workspace.pairs` and
/// `workspace.selected`.
inline RigidTransform least_squares_from_truth(const PoseCase& pose_case, TwoViewWorkspace& workspace) {
  NormalisedPairs& pairs = workspace.pairs;
  const ImageNormalisation intrinsics = intrinsics_of(pose_case.camera);
  normalise_pairs(pose_case.pairs, intrinsics, intrinsics, 1, pairs);
  workspace.selected.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pose_case.inlier[pairs.source[i]] == 0) continue;
    static_cast<void>(workspace.selected.push_back(static_cast<std::uint16_t>(i)));
  }
  RigidTransform pose = pose_case.truth;
  const RefinementParams params{RobustLoss::truncated, 1e3, 50, 1e-10};
  refine_relative_pose(pairs, {workspace.selected.data(), workspace.selected.size()}, params, pose);
  return pose;
}

}  // namespace ilp::test
