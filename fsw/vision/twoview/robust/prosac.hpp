// Samples for RANSAC, the matches of best quality first. Source: O. Chum, J. Matas, "Matching with PROSAC", CVPR 2005.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/rng.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

class ProsacSampler {
 public:
  /// Draws `sample_size` distinct matches a trial from `pairs`, which must outlive the sampler and hold at least as
  /// many. After `growth_trials` samples, or from the start when all qualities are equal, samples are uniform.
  ProsacSampler(const NormalisedPairs& pairs, std::size_t sample_size, std::uint32_t growth_trials, std::uint64_t seed);

  /// Indices into pairs.exact.
  void next(std::uint16_t* sample);

 private:
  const NormalisedPairs& pairs_;
  Rng rng_;
  std::size_t sample_size_;
  std::size_t pool_;               ///< samples come from the best `pool_` matches: n of the paper
  double expected_;                ///< T_n
  std::uint32_t next_growth_ = 1;  ///< T'_n
  std::uint32_t trial_ = 0;        ///< t
};

/// Trials after which a sample free of outliers has been drawn with probability `confidence`; at most `max_trials`.
[[nodiscard]] std::uint32_t required_trials(double inlier_share, std::size_t sample_size, double confidence,
                                            std::uint32_t max_trials);

}  // namespace ilp
