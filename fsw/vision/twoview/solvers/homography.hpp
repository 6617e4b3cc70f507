// Computes and decomposes homographies, the plane-induced maps of image a to image b: x_b ~ H x_a.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"
#include "fsw/vision/twoview/solvers/plane_motion.hpp"

namespace ilp {

/// The homography through four matches (indices into pairs.exact). Returns false if three of the points are on a line
/// in either image, or if the map reverses the orientation of a triangle, which is impossible for a plane that both
/// cameras see.
bool homography_from_four(const NormalisedPairs& pairs, const std::uint16_t sample[4], Mat3& homography);

/// Writes the motions and planes that explain a homography between normalised coordinates: two motions, each with both
/// signs of t and of the plane. Returns 4, or 0 if H is a rotation (no baseline) or degenerate. Source: Y. Ma, S.
/// Soatto, J. Kosecka, S. Sastry, "An Invitation to 3-D Vision", 5.3.3.
std::size_t decompose_homography(const Mat3& homography, PlaneMotion motions[4]);

}  // namespace ilp
