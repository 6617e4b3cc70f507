#include "sim/host/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp::host {

double percentile(std::vector<double> sample, double p) {
  if (sample.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::ptrdiff_t>(p * static_cast<double>(sample.size() - 1) + 0.5);
  std::nth_element(sample.begin(), sample.begin() + rank, sample.end());
  return sample[static_cast<std::size_t>(rank)];
}

double median(std::vector<double> sample) {
  return percentile(std::move(sample), 0.5);
}

ErrorSummary summarise(const std::vector<double>& errors) {
  ErrorSummary summary;
  summary.count = errors.size();
  if (errors.empty()) return summary;
  for (const double e : errors) {
    summary.mean += e;
    summary.rms += e * e;
    summary.max = std::max(summary.max, e);
  }
  summary.mean /= static_cast<double>(errors.size());
  summary.rms = std::sqrt(summary.rms / static_cast<double>(errors.size()));
  summary.median = median(errors);
  return summary;
}

}  // namespace ilp::host
