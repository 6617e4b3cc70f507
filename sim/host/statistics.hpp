// Order statistics of small samples.
#pragma once

#include <vector>

namespace ilp::host {

/// The `p` quantile, `p` in [0, 1], by nearest rank without interpolation; NaN for an empty sample.
[[nodiscard]] double percentile(std::vector<double> sample, double p);
/// percentile(sample, 0.5): of two middle values, the larger one.
[[nodiscard]] double median(std::vector<double> sample);

struct ErrorSummary {
  std::size_t count = 0;
  double mean = 0, rms = 0, max = 0, median = 0;
};
/// Summarises non-negative errors. All numbers are 0 for no errors.
[[nodiscard]] ErrorSummary summarise(const std::vector<double>& errors);

}  // namespace ilp::host
