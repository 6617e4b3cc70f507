// Removes false matches that lie on their epipolar line by chance.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// A false match that lies on its epipolar line by chance has a depth far from the terrain's. Over nearly flat terrain,
/// one such match outweighs all others in the parameters that a plane determines weakly. This function therefore
/// removes matches whose transfer error under the inliers' homography is much larger than that of the terrain's relief.
/// If there are more of them than chance explains, they are rocks and cliffs, and all matches stay.
///
/// `supported` are the matches of `all` within `bound_px` of the epipolar geometry, and `homography` is fitted to them.
/// `image_side_px` is the smaller side of image b. `kept` receives the indices into `all` of the matches that stay.
/// Returns false, with `kept` unchanged, if more matches lie far from it than chance explains. `errors` is scratch.
bool remove_chance_matches(const NormalisedPairs& all, const NormalisedPairs& supported, const Mat3& homography,
                           double threshold_px, double bound_px, double image_side_px,
                           FixedVector<double, limits::max_matches>& errors, PairIndices& kept);

/// The (upper) median; 0 if `values` is empty. Reorders the elements.
[[nodiscard]] double median_of(FixedVector<double, limits::max_matches>& values);

}  // namespace ilp
