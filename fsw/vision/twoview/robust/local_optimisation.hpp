// Selection of inliers and parameters of the local optimisation, shared by the problems of ransac().
#pragma once

#include "fsw/vision/twoview/refine/robust_loss.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// A model is refined on the matches within this multiple of the threshold: the right model gains matches that a noisy
/// sample misses.
inline constexpr double local_widening = 2;

[[nodiscard]] inline RefinementParams local_refinement(double threshold_px) {
  return {RobustLoss::truncated, threshold_px, 5, 1e-4};
}

/// Selects the matches with `squared_px(pair)` below the squared threshold. Returns the sum of these squared errors,
/// px^2.
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
