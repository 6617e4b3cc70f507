// Order statistics of small samples.
#pragma once

#include <vector>

namespace ilp::host {

/// The value that a share `p` in [0,1] of the sample lies below; NaN for an empty sample.
[[nodiscard]] double percentile(std::vector<double> sample, double p);
[[nodiscard]] double median(std::vector<double> sample);

struct ErrorSummary {
  std::size_t count = 0;
  double mean = 0, rms = 0, max = 0, median = 0;
};
/// Summarises errors, all of which are non-negative.
[[nodiscard]] ErrorSummary summarise(const std::vector<double>& errors);

}  // namespace ilp::host
