// When to stop scoring a sampled model. Source: D. Capel, "An Effective Bail-Out Test for RANSAC Consensus Scoring",
// BMVC 2005, for the truncated cost instead of the number of inliers.
#pragma once

#include <cstddef>

namespace ilp {

/// The cost below which a model is of interest.
struct CostBound {
  double cost = 1e300;  ///< px^2, sum over all matches
  /// The matches scored so far are a random sample of all. A model is abandoned if the total cost expected from the
  /// sample exceeds `cost` by this many standard deviations. With 0 it is abandoned only if its cost so far exceeds
  /// `cost`.
  double deviations = 0;
};

/// With three, one in 700 models as good as the best one so far is lost, and fewer of the better ones.
inline constexpr double sample_deviations = 3;

class BailOut {
 public:
  /// `largest`: highest cost of one match, px^2. `total`: number of matches.
  BailOut(const CostBound& bound, double largest, std::size_t total)
      : bound_(bound.cost), share_(bound.cost / (largest * static_cast<double>(total))), total_(total) {
    // Costs that are either 0 or `largest` have the largest variance of all costs with this mean.
    if (share_ < 1) variance_ = bound.deviations * bound.deviations * share_ * (1 - share_) * largest * largest;
    active_ = share_ < 1 && bound.deviations > 0;
  }

  /// True if a model whose first `seen` matches cost `cost` is abandoned.
  [[nodiscard]] bool operator()(double cost, std::size_t seen) const {
    if (!(cost < bound_)) return true;
    if (!active_) return false;
    const auto n = static_cast<double>(seen);
    const auto all = static_cast<double>(total_);
    const double excess = cost - bound_ * n / all;
    return excess > 0 && excess * excess > variance_ * n * (1 - n / all);
  }

 private:
  double bound_;
  double share_;  ///< bound / largest cost that all matches can have together
  double variance_ = 0;
  std::size_t total_;
  bool active_ = false;
};

}  // namespace ilp
