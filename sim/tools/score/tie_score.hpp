// The ties of a flight against the places that the true cameras give its strips.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/score.hpp"

namespace ilp::score {

// Whether the stated errors of ties are honest.
//
// A strip's world is defined by its first camera and its first baseline (pose_score.hpp). The truth laid onto both
// strips in this way gives the true tie T; the error of the tie S is the step that takes the identity to S^-1 T, in the
// newer strip's world and unit, like the stated covariance: rotation vector, translation and logarithm of the scale.

/// With exact covariances 68.3 % of the components are within one sigma and 95.4 % within two, and the normalised error
/// squared, over all seven components together, is 1. The components of a tie hang together, so shares are worth
/// something over many ties only.
struct TieScore {
  std::size_t ties = 0;  ///< whose strips the truth knows from their first keyframe on
  std::size_t components = 0, within_one = 0, within_two = 0;
  double squared_sum = 0;             ///< squared Mahalanobis distances of the errors
  std::vector<double> place_percent;  ///< where the tie puts the newest linked camera, % of its ground distance
  std::vector<double> scale_percent;  ///< absolute errors of the scale
  [[nodiscard]] double share_within_one() const;
  [[nodiscard]] double share_within_two() const;
  [[nodiscard]] double normalised_error_squared() const;
};

[[nodiscard]] TieScore score_ties(const std::vector<TieRecord>& ties, const std::vector<StripScore>& strips);

/// For tables over many flights; empty without ties.
[[nodiscard]] std::map<std::string, double> tie_summary(const TieScore& score);

}  // namespace ilp::score
