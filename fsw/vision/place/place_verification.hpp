// Decides from the features alone whether two keyframes show the same ground. A wrong "no" is acceptable, a wrong "yes"
// is not.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/base/geometry.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/place/place_features.hpp"

namespace ilp {

/// Least PlaceMatch::evidence of the same ground, if no other information supports it.
inline constexpr float least_place_evidence = 6;

struct PlacePair {
  std::uint16_t older = 0, newer = 0;  ///< indices of features in the older and the newer image
};
using PlacePairs = FixedVector<PlacePair, limits::max_place_features>;

struct PlaceMatch {
  PlaceVerdict verdict = PlaceVerdict::too_few_features;
  /// The mapping between the images, in full-resolution pixels, as a similarity and as a homography. Valid if the
  /// verdict is `verified`.
  Similarity2 newer_from_older;
  double plane_newer_from_older[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major; models the tilt of the cameras
  double residual_px = 0;    ///< RMS distance of the guided matches from the plane's mapping, per axis
  std::int32_t inliers = 0;  ///< matches that agree with the first similarity
  std::int32_t cells = 0;    ///< cells of the image with a guided match; the smaller number of both images
  double spread_px = 0;      ///< standard deviation of the guided matches along the direction of least spread
  /// Evidence against chance: -ln of Hoeffding's bound on the probability that at least as many corners have a guided
  /// match by chance. The rate of chance matches is that of the six best maps which start beside this one and are
  /// refined in the same way. This and the next two values stay 0 if the cells or the spread are too small.
  double evidence = 0;
  double rival_share = 0;  ///< evidence of the best other map divided by `evidence`
  double rival_rate = 0;   ///< share of corners with a match under that map divided by the share under this one
  PlacePairs pairs;        ///< guided matches, in order of the older image's features
};

struct PlaceMatchWorkspace;  // place_match_workspace.hpp
/// Verifies a pair of keyframes. `min_evidence`: least PlaceMatch::evidence. Deterministic: every pair of the best
/// matches is tried, without random samples. Different ground is no error: see PlaceMatch::verdict. Returns
/// `invalid_argument` if there are more than limits::max_place_features features.
Status verify_place(std::span<const PlaceFeature> older, std::span<const PlaceFeature> newer, float min_evidence,
                    PlaceMatchWorkspace& workspace, PlaceMatch& match);

}  // namespace ilp
