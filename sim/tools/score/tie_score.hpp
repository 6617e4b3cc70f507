// Scores the ties of a flight against the true similarities between its strips.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/score.hpp"

namespace ilp::score {

// Compares the errors of ties with their estimated covariances.
//
// A strip's world is defined by its first camera and its first baseline (pose_score.hpp). Aligning the truth to both
// strips in this gauge gives the true tie T. The error of the tie S is the step from the identity to S^-1 T: rotation
// vector, translation and logarithm of the scale. Like the covariance, the error is in the newer strip's world and
// unit.

/// The components of a tie are correlated, so that shares are meaningful over many ties only.
struct TieScore {
  std::size_t ties = 0;  ///< scored ties: the truth knows the first two posed keyframes of both strips
  SigmaScore sigmas;     ///< seven components per tie; squared_sum is the sum of squared Mahalanobis distances
  std::vector<double>
      place_percent;  ///< error of the newest linked camera's position by the tie, % of its distance to the ground
  std::vector<double> scale_percent;  ///< absolute errors of the scale
};

/// Scores all ties except those that the ground segment does not use (model::similarity_by_tie) and those of strips
/// with a measured scale.
[[nodiscard]] TieScore score_ties(const intake::Flight& flight, const std::vector<StripScore>& strips);

/// Numbers for tables over many flights; empty without ties.
[[nodiscard]] std::map<std::string, double> tie_summary(const TieScore& score);

}  // namespace ilp::score
