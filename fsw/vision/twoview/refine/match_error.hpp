// Squared distances of a match from an epipolar geometry or a homography, px^2.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Squared Sampson distance: to first order, the squared distance from (xa, ya, xb, yb) to the nearest match that
/// satisfies b^T M a = 0. M is an essential or fundamental matrix. Source: R. Hartley, A. Zisserman, "Multiple View
/// Geometry" (2nd ed.), eq. 11.9.
[[nodiscard]] double sampson_squared(const Mat3& m, const NormalisedPair& pair, const PixelScale& scale);

/// Squared distance from H x_a to x_b; infinite if H x_a is behind camera b.
[[nodiscard]] double transfer_squared(const Mat3& homography, const NormalisedPair& pair, const PixelScale& scale);

/// Squared Sampson distance from (xa, ya, xb, yb) to the nearest match with x_b ~ H x_a; infinite if H x_a is behind
/// camera b (O. Chum, T. Pajdla, P. Sturm, "The Geometric Error for Homographies", CVIU 2005).
[[nodiscard]] double homography_sampson_squared(const Mat3& homography, const NormalisedPair& pair,
                                                const PixelScale& scale);

}  // namespace ilp
