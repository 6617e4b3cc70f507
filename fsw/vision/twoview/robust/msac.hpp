// MSAC: the cost of a match is min(squared error, squared threshold). Source: P. Torr, A. Zisserman, "MLESAC", CVIU
// 2000.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp {

struct RansacScore {
  double cost = 0;  ///< px^2; the smallest is the best
  std::uint32_t inliers = 0;
};

/// Block size in matches. After each block, scoring stops early if the model can no longer be the best.
inline constexpr std::size_t score_block = 32;

/// Adds the MSAC cost and the number of inliers of `squared[0..count)` (px^2) to `score`. Sets the remaining elements
/// to 0. They count as inliers without cost, which the last line subtracts again: `threshold2`, the squared inlier
/// threshold (px^2), must therefore be above 0. A NaN counts as an outlier: the Sampson error is NaN if both points lie
/// at their epipoles. The sums run in four lanes, which fit a vector register.
inline void add_block(float (&squared)[score_block], std::size_t count, float threshold2, RansacScore& score) {
  constexpr std::size_t lanes = 4;
  for (std::size_t i = count; i < score_block; ++i) squared[i] = 0;
  float cost[lanes] = {};
  std::uint32_t inliers[lanes] = {};
  for (std::size_t i = 0; i < score_block; i += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) {
      const bool inlier = squared[i + k] < threshold2;
      cost[k] += inlier ? squared[i + k] : threshold2;
      inliers[k] += inlier ? 1U : 0U;
    }
  }
  score.cost += static_cast<double>((cost[0] + cost[1]) + (cost[2] + cost[3]));
  score.inliers += (inliers[0] + inliers[1]) + (inliers[2] + inliers[3]);
  score.inliers -= static_cast<std::uint32_t>(score_block - count);
}

}  // namespace ilp
