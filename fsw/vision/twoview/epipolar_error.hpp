// Sampson's distance: how far, to first order, a match is from satisfying b^T M a = 0, M an essential or fundamental
// matrix. Source: R. Hartley, A. Zisserman, "Multiple View Geometry" (2nd ed.), eq. 11.9.
#pragma once

#include "fsw/vision/twoview/normalised_pairs.hpp"
#include "fsw/vision/twoview/ransac.hpp"

namespace ilp {

/// Pixels squared: distance of (xa, ya, xb, yb) from the epipolar variety, in the metric of the pixels.
[[nodiscard]] double sampson_squared(const Mat3& m, const NormalisedPair& pair, const PixelScale& scale);

/// MSAC score of all matches; false as soon as `bound` gives the matrix up.
bool score_epipolar(const NormalisedPairs& pairs, const Mat3& m, double threshold_px, const CostBound& bound,
                    RansacScore& score);

/// The same for a pose: a match that does not meet in front of both cameras is an outlier, unless its parallax is
/// within `threshold_px`, where noise decides the sign of the depth.
bool score_pose(const NormalisedPairs& pairs, const RigidTransform& b_from_a, double threshold_px,
                const CostBound& bound, RansacScore& score);

/// Angle under which `threshold_px` is seen.
[[nodiscard]] double threshold_angle(const PixelScale& scale, double threshold_px);

}  // namespace ilp
