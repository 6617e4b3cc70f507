// Non-linear least squares on Sampson's distance: five parameters of a relative pose, seven of a fundamental matrix.
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/refine/narrow_motion.hpp"
#include "fsw/vision/twoview/refine/robust_loss.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// `b_from_a` keeps |t| = 1. False when nothing was gained.
bool refine_relative_pose(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          RigidTransform& b_from_a);

/// The same in the terms of a narrow field, where the turn is found in few steps. It keeps its sign.
bool refine_narrow_motion(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          NarrowMotion& motion);

/// What refine_relative_pose minimises, px^2.
[[nodiscard]] double epipolar_cost(const NormalisedPairs& pairs, const PairSelection& selection,
                                   const RefinementParams& params, const RigidTransform& b_from_a);

/// `fundamental` has rank two and refers to normalised coordinates; it is varied as U diag(1, s, 0) V^T, where U and V
/// are rotations (A. Bartoli, P. Sturm,
/// "Nonlinear Estimation of the Fundamental Matrix with Minimal Parameters", PAMI 2004).
bool refine_fundamental(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                        Mat3& fundamental);

/// One-sigma errors of the rotation and of the direction of translation (about the worst axis, rad), if the matches
/// have an error of `sigma_px`. An error is infinite if the matches do not determine it.
void pose_uncertainty(const NormalisedPairs& pairs, const PairSelection& selection, const RigidTransform& b_from_a,
                      double sigma_px, double& sigma_rotation_rad, double& sigma_direction_rad);

}  // namespace ilp
