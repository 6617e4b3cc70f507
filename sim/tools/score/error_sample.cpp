#include "sim/tools/score/error_sample.hpp"

#include <cmath>

#include "sim/host/statistics.hpp"

namespace ilp::score {

ErrorPercent error_percent(const std::vector<float>& signed_percent) {
  ErrorPercent summary;
  summary.count = signed_percent.size();
  if (signed_percent.empty()) return summary;
  std::vector<double> values(signed_percent.begin(), signed_percent.end());
  summary.bias = host::median(values);
  for (double& value : values) value = std::fabs(value);
  summary.median = host::median(values);
  summary.p95 = host::percentile(std::move(values), 0.95);
  return summary;
}

SigmaShares sigma_shares(const std::vector<float>& errors_in_sigmas) {
  SigmaShares shares;
  shares.count = errors_in_sigmas.size();
  if (errors_in_sigmas.empty()) return shares;
  std::vector<double> squares;
  std::size_t one = 0, two = 0;
  double sum = 0;
  for (const float error : errors_in_sigmas) {
    const double square = static_cast<double>(error) * error;
    squares.push_back(square);
    sum += square;
    one += square <= 1 ? 1U : 0U;
    two += square <= 4 ? 1U : 0U;
  }
  const auto n = static_cast<double>(shares.count);
  constexpr double median_of_chi_square = 0.454936;  // one degree of freedom
  shares.within_1 = static_cast<double>(one) / n;
  shares.within_2 = static_cast<double>(two) / n;
  shares.squared = sum / n;
  shares.squared_robust = host::median(std::move(squares)) / median_of_chi_square;
  return shares;
}

}  // namespace ilp::score
