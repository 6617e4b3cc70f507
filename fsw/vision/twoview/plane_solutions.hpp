// Finds the motions that explain the homography of a plane and keep its points visible (decisions.md, 7).
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"
#include "fsw/vision/twoview/solvers/plane_motion.hpp"

namespace ilp {

/// Decomposes `homography` (normalised coordinates) and keeps the motions with at least nine tenths of the matches on
/// the plane in front of both cameras. A match is on the plane if its transfer error is below `threshold_px`. If two
/// motions remain, the first is the one nearer to `pose`; the second is dropped if its translation differs by less than
/// one degree. Source: R. Tsai, T. Huang, W. Zhu, "Estimating Three-Dimensional Motion Parameters of a Rigid Planar
/// Patch, II", 1982.
void find_plane_solutions(const NormalisedPairs& pairs, const Mat3& homography, const RigidTransform& pose,
                          double threshold_px, PlaneSolutions& solutions);

}  // namespace ilp
