// Tells whether two keyframes show the same ground, from their features alone. A wrong "yes" must not happen; a wrong
// "no" may.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/base/geometry.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/place/place_features.hpp"

namespace ilp {

/// Least PlaceMatch::evidence of the same ground, where nothing but the features says that it is.
inline constexpr float least_place_evidence = 6;

struct PlacePair {
  std::uint16_t older = 0, newer = 0;  ///< indices of features
};
using PlacePairs = FixedVector<PlacePair, limits::max_place_features>;

struct PlaceMatch {
  PlaceVerdict verdict = PlaceVerdict::too_few_features;
  /// Full-resolution pixels; both are valid if verified.
  Similarity2 newer_from_older;
  double plane_newer_from_older[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major; follows the tilt of the cameras
  double residual_px = 0;    ///< root mean square of the guided matches about the plane, per axis
  std::int32_t inliers = 0;  ///< of the first similarity
  std::int32_t cells = 0;    ///< with a guided match, of the image that has fewer
  double spread_px = 0;
  /// Against chance: -ln of Hoeffding's bound on the probability that as many corners have a guided match if each has
  /// one as often as under the six maps that find most of those that start beside this one and are followed in the same
  /// way. This and the rivals are not computed where cells or spread are too few.
  double evidence = 0;
  double rival_share = 0;  ///< evidence of the best other place, as a share of that of this one
  double rival_rate = 0;   ///< how often corners have a match there, as a share of how often here
  PlacePairs pairs;        ///< guided matches, in order of the older image's features
};

struct PlaceMatchWorkspace;  // place_match_workspace.hpp
/// Deterministic: every pair of the best matches is tried, none is drawn. A pair of images that do not show the same
/// ground is no error: see PlaceMatch::verdict. `invalid_argument` (more than limits::max_place_features).
Status verify_place(std::span<const PlaceFeature> older, std::span<const PlaceFeature> newer, float min_evidence,
                    PlaceMatchWorkspace& workspace, PlaceMatch& match);

}  // namespace ilp
