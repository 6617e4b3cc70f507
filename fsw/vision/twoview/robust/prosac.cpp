#include "fsw/vision/twoview/robust/prosac.hpp"

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {

ProsacSampler::ProsacSampler(const NormalisedPairs& pairs, std::size_t sample_size, std::uint32_t growth_trials,
                             std::uint64_t seed)
    : pairs_(&pairs),
      rng_(seed),
      sample_size_(sample_size),
      pool_(pairs.qualities_differ ? sample_size : pairs.size()),
      expected_(growth_trials) {
  for (std::size_t i = 0; i < sample_size_; ++i) {
    expected_ *= static_cast<double>(sample_size_ - i) / static_cast<double>(pairs.size() - i);
  }
}

void ProsacSampler::next(std::uint16_t* sample) {
  ++trial_;
  const bool growing = pool_ < pairs_->size();
  if (growing && trial_ == next_growth_) {
    const double grown = expected_ * static_cast<double>(pool_ + 1) / static_cast<double>(pool_ + 1 - sample_size_);
    next_growth_ += static_cast<std::uint32_t>(std::ceil(grown - expected_));
    expected_ = grown;
    ++pool_;
  }
  // The newest match of the pool is in the sample, because samples of the others were drawn before.
  std::size_t drawn = 0;
  if (growing) sample[drawn++] = pairs_->by_quality[pool_ - 1];
  const auto others = static_cast<std::uint32_t>(growing ? pool_ - 1 : pool_);
  while (drawn < sample_size_) {
    const std::uint16_t candidate = pairs_->by_quality[rng_.below(others)];
    bool fresh = true;
    for (std::size_t i = 0; i < drawn; ++i) fresh &= sample[i] != candidate;
    if (fresh) sample[drawn++] = candidate;
  }
}

std::uint32_t required_trials(double inlier_share, std::size_t sample_size, double confidence,
                              std::uint32_t max_trials) {
  double clean = 1;
  for (std::size_t i = 0; i < sample_size; ++i) clean *= inlier_share;
  if (!(clean > 0) || !(confidence < 1)) return max_trials;
  if (clean >= 1) return 1;
  const double trials = std::ceil(det_log(1 - confidence) / det_log(1 - clean));
  if (!(trials < max_trials)) return max_trials;
  return trials < 1 ? 1 : static_cast<std::uint32_t>(trials);
}

}  // namespace ilp
