// MSAC scores of the models of two views (msac.hpp).
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/robust/bail_out.hpp"
#include "fsw/vision/twoview/robust/msac.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Scores an essential or fundamental matrix by Sampson's distance. Returns false if `bound` abandons the model.
bool score_epipolar(const NormalisedPairs& pairs, const Mat3& m, double threshold_px, const CostBound& bound,
                    RansacScore& score);

/// Scores a pose. A match whose rays do not meet in front of both cameras is an outlier, unless its parallax is within
/// `threshold_px`: noise then decides the sign of the depth. Returns false if `bound` abandons the model.
bool score_pose(const NormalisedPairs& pairs, const RigidTransform& b_from_a, double threshold_px,
                const CostBound& bound, RansacScore& score);

/// The angle that `threshold_px` spans at the centre of image b, rad.
[[nodiscard]] double threshold_angle(const PixelScale& scale, double threshold_px);

/// Scores a homography by the transfer error. Returns false if `bound` abandons the model.
bool score_homography(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px, const CostBound& bound,
                      RansacScore& score);

}  // namespace ilp
