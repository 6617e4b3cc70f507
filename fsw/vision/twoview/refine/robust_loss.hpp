// The loss that keeps false matches from pulling a refined model away.
#pragma once

#include <cstdint>

namespace ilp {

/// Cost of a match with error r, for the bound c.
enum class RobustLoss : std::uint8_t {
  truncated,  ///< min(r^2, c^2)
  tukey,      ///< smooth, constant beyond c (J. W. Tukey's biweight)
};

struct RefinementParams {
  RobustLoss loss = RobustLoss::truncated;
  double bound_px = 1;  ///< the cost of larger errors is constant
  std::uint32_t max_steps = 10;
  double min_gain = 1e-6;  ///< the refinement ends if a step lowers the cost by a smaller share
};

/// Cost of one match (px^2), and the weight of its squared error in the normal equations.
struct RobustCost {
  double cost;
  double weight;
};

[[nodiscard]] inline RobustCost robust_cost(RobustLoss loss, double squared, double bound2) {
  if (!(squared < bound2)) return {loss == RobustLoss::tukey ? bound2 / 3 : bound2, 0};
  if (loss == RobustLoss::truncated) return {squared, 1};
  const double rest = 1 - squared / bound2;
  return {bound2 / 3 * (1 - rest * rest * rest), rest * rest};
}

}  // namespace ilp
