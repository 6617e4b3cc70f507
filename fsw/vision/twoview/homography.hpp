// The plane-induced map of one image onto another: x_b ~ H x_a.
#pragma once

#include "fsw/vision/twoview/epipolar_refinement.hpp"
#include "fsw/vision/twoview/plane_motion.hpp"
#include "fsw/vision/twoview/ransac.hpp"

namespace ilp {

/// H through four matches (indices into pairs.exact); false when three of them are on a line in either image, or when
/// the map turns one of the triangles inside out, which no plane seen by both cameras does.
bool homography_from_four(const NormalisedPairs& pairs, const std::uint16_t sample[4], Mat3& homography);

/// Least squares over four matches or more by direct linear transform (R. Hartley, A. Zisserman, "Multiple View
/// Geometry", 4.1); `pairs` are normalised already. False when the matches leave more than one solution.
bool fit_homography(const NormalisedPairs& pairs, const PairSelection& selection, Mat3& homography);

/// Non-linear least squares on the transfer error. False when nothing was gained.
bool refine_homography(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                       Mat3& homography);

/// Distance from H x_a to x_b, px^2; infinite behind the camera.
[[nodiscard]] double transfer_squared(const Mat3& homography, const NormalisedPair& pair, const PixelScale& scale);

/// Sampson's distance of (xa, ya, xb, yb) from the variety of matches under H, px^2 (O. Chum, T. Pajdla, P. Sturm, "The
/// Geometric Error for Homographies", CVIU 2005).
[[nodiscard]] double homography_sampson_squared(const Mat3& homography, const NormalisedPair& pair,
                                                const PixelScale& scale);

/// MSAC score on the transfer error; false as soon as `bound` gives the homography up.
bool score_homography(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px, const CostBound& bound,
                      RansacScore& score);

/// The motions that a homography between normalised coordinates may come from: two, each for both signs of t and of the
/// plane. Returns 4, or 0 when H is a rotation (no baseline) or degenerate. Source: Y. Ma, S. Soatto, J. Kosecka, S.
/// Sastry, "An Invitation to 3-D Vision", 5.3.3.
std::size_t decompose_homography(const Mat3& homography, PlaneMotion motions[4]);

}  // namespace ilp
