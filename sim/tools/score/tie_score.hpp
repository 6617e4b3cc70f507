// The ties of a flight against the places that the true cameras give its strips.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/score.hpp"

namespace ilp::score {

// Whether the estimated errors of ties are honest.
//
// A strip's world is defined by its first camera and its first baseline (pose_score.hpp). The truth laid onto both
// strips in this way gives the true tie T; the error of the tie S is the step that takes the identity to S^-1 T, in the
// newer strip's world and unit, like the stated covariance: rotation vector, translation and logarithm of the scale.

/// The components of a tie are correlated, so that shares say something over many ties only.
struct TieScore {
  std::size_t ties = 0;  ///< whose strips the truth knows from their first keyframe on
  SigmaScore sigmas;     ///< seven components per tie; squared_sum is of Mahalanobis distances
  std::vector<double>
      place_percent;  ///< error of where the tie puts the newest linked camera, % of its ground distance
  std::vector<double> scale_percent;  ///< absolute errors of the scale
};

/// Ties that the ground does not use (model::similarity_by_tie) and strips with a measured scale are left out.
[[nodiscard]] TieScore score_ties(const intake::Flight& flight, const std::vector<StripScore>& strips);

/// For tables over many flights; empty without ties.
[[nodiscard]] std::map<std::string, double> tie_summary(const TieScore& score);

}  // namespace ilp::score
