// Distances of a match from the models of two views, px^2.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Sampson's distance: the distance, to first order, of (xa, ya, xb, yb) from satisfying b^T M a = 0, M an essential or
/// fundamental matrix. Source: R. Hartley, A. Zisserman, "Multiple View Geometry" (2nd ed.), eq. 11.9.
[[nodiscard]] double sampson_squared(const Mat3& m, const NormalisedPair& pair, const PixelScale& scale);

/// Distance from H x_a to x_b, px^2; infinite behind the camera.
[[nodiscard]] double transfer_squared(const Mat3& homography, const NormalisedPair& pair, const PixelScale& scale);

/// Sampson's distance of (xa, ya, xb, yb) from the variety of matches under H, px^2 (O. Chum, T. Pajdla, P. Sturm, "The
/// Geometric Error for Homographies", CVIU 2005).
[[nodiscard]] double homography_sampson_squared(const Mat3& homography, const NormalisedPair& pair,
                                                const PixelScale& scale);

}  // namespace ilp
