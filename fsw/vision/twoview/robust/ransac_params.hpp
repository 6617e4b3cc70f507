// The parameters of the robust estimators.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

struct RansacParams {
  double threshold_px = 1.0;        ///< inlier threshold of the Sampson (E, F) or transfer (H) error
  double confidence = 0.9999;       ///< probability that at least one sample has no outlier
  std::uint32_t max_trials = 1000;  ///< at most limits::max_ransac_trials
  std::uint32_t min_inliers = 20;   ///< with fewer there is no result
  std::uint64_t seed = 1;           ///< seed of the random samples, made from record ids
};

/// Returns `invalid_argument`, with the name of the field, if a field is out of range or not finite.
Status validate(const RansacParams& params);

}  // namespace ilp
