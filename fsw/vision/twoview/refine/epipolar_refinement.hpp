// Non-linear least squares on Sampson's distance: five parameters of a relative pose, seven of a fundamental matrix.
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/refine/narrow_motion.hpp"
#include "fsw/vision/twoview/refine/robust_loss.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Refines `b_from_a`; |t| stays 1. Returns false if the cost did not fall or fewer than five matches are selected.
bool refine_relative_pose(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          RigidTransform& b_from_a);

/// As refine_relative_pose, in the parameters of a narrow field of view (narrow_motion.hpp), where the turn converges
/// in few steps. The sign of the turn does not change.
bool refine_narrow_motion(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          NarrowMotion& motion);

/// The cost that refine_relative_pose minimises, px^2.
[[nodiscard]] double epipolar_cost(const NormalisedPairs& pairs, const PairSelection& selection,
                                   const RefinementParams& params, const RigidTransform& b_from_a);

/// Refines `fundamental`, which has rank two and refers to normalised coordinates. It is parametrised as U diag(1, s,
/// 0) V^T with rotations U and V (A. Bartoli, P. Sturm, "Nonlinear Estimation of the Fundamental Matrix with Minimal
/// Parameters", PAMI 2004).
bool refine_fundamental(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                        Mat3& fundamental);

/// Computes the standard deviations of the rotation and of the direction of translation (about the worst axis, rad)
/// from the standard deviation `sigma_px` of the matches. A result is infinite if the matches do not determine it.
void pose_uncertainty(const NormalisedPairs& pairs, const PairSelection& selection, const RigidTransform& b_from_a,
                      double sigma_px, double& sigma_rotation_rad, double& sigma_direction_rad);

}  // namespace ilp
