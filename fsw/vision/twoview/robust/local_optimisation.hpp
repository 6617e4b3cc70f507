// What the problems of ransac() share: the inliers of a model, and how the model is refined on them.
#pragma once

#include "fsw/vision/twoview/refine/robust_loss.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// A model is refined on the matches within this many thresholds: the right one gains matches that a noisy sample
/// misses.
inline constexpr double local_widening = 2;

[[nodiscard]] inline RefinementParams local_refinement(double threshold_px) {
  return {RobustLoss::truncated, threshold_px, 5, 1e-4};
}

/// The matches for which `squared_px(pair)` is below the squared threshold; returns the sum of these.
template <typename SquaredError>
double select_matches(const NormalisedPairs& pairs, double threshold_px, PairIndices& selected,
                      const SquaredError& squared_px) {
  double sum = 0;
  selected.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double squared = squared_px(pairs.exact[i]);
    if (!(squared < threshold_px * threshold_px)) continue;
    static_cast<void>(selected.push_back(static_cast<std::uint16_t>(i)));  // same capacity as `pairs`
    sum += squared;
  }
  return sum;
}

}  // namespace ilp
