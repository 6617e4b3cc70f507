// False matches that lie on their epipolar line by chance.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// A false match that happens to lie on its epipolar line has a depth far from the terrain's. Over nearly flat terrain
/// one such match outweighs all the others in the directions that a plane leaves weak. So this function puts matches
/// aside that lie far off the homography of the inliers, compared with the terrain's own relief. If there are more of
/// them than chance explains, they are rocks and cliffs, and stay.
///
/// `supported` are the matches of `all` within `bound_px` of the epipolar geometry, and `homography` is fitted to them.
/// `image_side_px` is the smaller side of image b. `kept` receives the indices into `all` of the matches that stay; the
/// function returns false when all of them do. `errors` is scratch.
bool remove_chance_matches(const NormalisedPairs& all, const NormalisedPairs& supported, const Mat3& homography,
                           double threshold_px, double bound_px, double image_side_px,
                           FixedVector<double, limits::max_matches>& errors, PairIndices& kept);

/// Zero if there are no values. The elements change places.
[[nodiscard]] double median_of(FixedVector<double, limits::max_matches>& values);

}  // namespace ilp
