// Signed errors in per cent of the flying height, and what is said of many of them.
#pragma once

#include <cstddef>
#include <vector>

#include "fsw/records/records.hpp"

namespace ilp::score {

struct ErrorPercent {
  std::size_t count = 0;
  double bias = unknown;    ///< median of the signed errors
  double median = unknown;  ///< of their absolute values
  double p95 = unknown;     ///< 95 % of the absolute values lie below
};

[[nodiscard]] ErrorPercent error_percent(const std::vector<float>& signed_percent);

/// How the errors compare with the sigmas stated for them: 0.683, 0.954, 1 and 1 are perfect for normal errors.
struct SigmaShares {
  std::size_t count = 0;
  double within_1 = unknown, within_2 = unknown;  ///< shares of the errors
  double squared = unknown;                       ///< mean of (error / sigma)^2
  double squared_robust = unknown;                ///< the same from its median: without the few that are far off
};

[[nodiscard]] SigmaShares sigma_shares(const std::vector<float>& errors_in_sigmas);

}  // namespace ilp::score
