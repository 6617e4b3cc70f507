// MSAC scores of the models of two views (msac.hpp).
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/robust/bail_out.hpp"
#include "fsw/vision/twoview/robust/msac.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// MSAC score of all matches; false as soon as `bound` gives the matrix up.
bool score_epipolar(const NormalisedPairs& pairs, const Mat3& m, double threshold_px, const CostBound& bound,
                    RansacScore& score);

/// The same for a pose: a match that does not meet in front of both cameras is an outlier, unless its parallax is
/// within `threshold_px`, where noise decides the sign of the depth.
bool score_pose(const NormalisedPairs& pairs, const RigidTransform& b_from_a, double threshold_px,
                const CostBound& bound, RansacScore& score);

/// Angle under which `threshold_px` is seen.
[[nodiscard]] double threshold_angle(const PixelScale& scale, double threshold_px);

/// MSAC score on the transfer error; false as soon as `bound` gives the homography up.
bool score_homography(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px, const CostBound& bound,
                      RansacScore& score);

}  // namespace ilp
