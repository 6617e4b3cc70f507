// The loss that keeps false matches from pulling a refined model away.
#pragma once

#include <cstdint>

namespace ilp {

/// Bound of the robust cost, and what happens beyond it.
enum class RobustLoss : std::uint8_t {
  truncated,  ///< min(r^2, c^2)
  tukey,      ///< smooth, constant beyond c (J. W. Tukey's biweight)
};

struct RefinementParams {
  RobustLoss loss = RobustLoss::truncated;
  double bound_px = 1;
  int max_steps = 10;
  double min_gain = 1e-6;
};

}  // namespace ilp
