// The two-fold ambiguity of a plane (decisions.md, 7): the solutions that visibility allows.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"
#include "fsw/vision/twoview/solvers/plane_motion.hpp"

namespace ilp {

/// Finds the solutions of `homography`, with the number of matches within `threshold_px` of it in front of both
/// cameras. The first is the one nearest to `pose`. Source: R. Tsai, T. Huang, W. Zhu, "Estimating Three-Dimensional
/// Motion Parameters of a Rigid Planar Patch, II", 1982: of the two, points in front of both cameras leave one or both.
void find_plane_solutions(const NormalisedPairs& pairs, const Mat3& homography, const RigidTransform& pose,
                          double threshold_px, PlaneSolutions& solutions);

}  // namespace ilp
