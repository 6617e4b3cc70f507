// Noise of measurements.
#pragma once

#include "fsw/base/rng.hpp"

namespace ilp::navigation {

/// Normal numbers, as the sum of twelve uniform ones.
inline double normal(Rng& rng) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += rng.uniform();
  return sum;
}

}  // namespace ilp::navigation
