// False matches that lie on their epipolar line by chance.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// A false match that happens to lie on its epipolar line has a depth far from the terrain's. Where the terrain is
/// nearly flat one such match outweighs all the others in the directions that a plane leaves weak. So matches far off
/// the homography of the inliers, on the scale of the terrain's own relief, are put aside: unless they are more than
/// chance explains, which makes them rocks and cliffs.
///
/// `supported` are those of `all` within `bound_px` of the epipolar geometry, `homography` is theirs; `image_side_px`
/// is the smaller side of image b. `kept` receives the indices into `all` of what stays; false when all does. The
/// contents of `errors` do not matter.
bool put_chance_matches_aside(const NormalisedPairs& all, const NormalisedPairs& supported, const Mat3& homography,
                              double threshold_px, double bound_px, double image_side_px,
                              FixedVector<double, limits::max_matches>& errors, PairIndices& kept);

/// Zero of none; the elements change places.
[[nodiscard]] double median_of(FixedVector<double, limits::max_matches>& values);

}  // namespace ilp
