// Samples for RANSAC that take the matches of best quality first. Source: O. Chum, J. Matas, "Matching with PROSAC",
// CVPR 2005.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/rng.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

class ProsacSampler {
 public:
  ProsacSampler() = default;  ///< draws nothing until another one is assigned
  /// Draws `sample_size` distinct matches from `pairs` in each trial. `pairs` must outlive the sampler and hold at
  /// least `sample_size` matches. Samples are uniform after `growth_trials` samples, or from the start if all qualities
  /// are equal.
  ProsacSampler(const NormalisedPairs& pairs, std::size_t sample_size, std::uint32_t growth_trials, std::uint64_t seed);

  /// Writes `sample_size` indices into pairs.exact.
  void next(std::uint16_t* sample);

 private:
  const NormalisedPairs* pairs_ = nullptr;
  Rng rng_{0};
  std::size_t sample_size_ = 0;
  std::size_t pool_ = 0;           ///< samples come from the best `pool_` matches: n of the paper
  double expected_ = 0;            ///< T_n
  std::uint32_t next_growth_ = 1;  ///< T'_n
  std::uint32_t trial_ = 0;        ///< t
};

/// Number of trials after which at least one sample has no outlier with probability `confidence`; at most `max_trials`.
[[nodiscard]] std::uint32_t required_trials(double inlier_share, std::size_t sample_size, double confidence,
                                            std::uint32_t max_trials);

}  // namespace ilp
