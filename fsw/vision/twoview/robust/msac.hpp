// MSAC: every match costs its squared error, at most the squared threshold. Source: P. Torr, A. Zisserman, "MLESAC",
// CVIU 2000.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp {

struct RansacScore {
  double cost = 0;  ///< px^2; less is better
  std::uint32_t inliers = 0;
};

/// After this many matches scoring checks whether the model can still be the best one.
inline constexpr std::size_t score_block = 32;

/// Adds the first `count` squared errors and overwrites the others. NaN counts as an outlier; a match at both epipoles
/// has it. The sums run in four lanes, which fit a vector register.
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
