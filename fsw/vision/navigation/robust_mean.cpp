#include "fsw/vision/navigation/robust_mean.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/median.hpp"

namespace ilp::navigation {
namespace {

constexpr double farthest_sigmas = 4;

}  // namespace

double median_of(std::span<double> values) {
  if (values.empty()) return 0;
  const double upper = upper_median(values);
  if (values.size() % 2 == 1) return upper;
  const auto half = static_cast<std::ptrdiff_t>(values.size() / 2);
  return 0.5 * (upper + *std::max_element(values.begin(), values.begin() + half));
}

double inflation(std::span<const double> residuals) {
  double squares = 0, products = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    squares += residuals[i] * residuals[i];
    if (i > 0) products += residuals[i] * residuals[i - 1];
  }
  if (!(squares > 0) || residuals.size() < 4) return 1;
  const double correlation = std::clamp(products / squares, 0.0, 0.95);
  return (1 + correlation) / (1 - correlation);
}

RobustMean robust_mean(const Measurements& values) {
  RobustMean mean;
  std::array<double, max_values> scratch;
  std::size_t count = 0;
  for (const Measured& m : values) scratch[count++] = m.value;
  const double median = median_of(std::span(scratch).first(count));
  count = 0;
  for (const Measured& m : values) scratch[count++] = std::fabs(m.value - median);
  const double scatter = sigma_per_mad * median_of(std::span(scratch).first(count));

  const auto belongs = [&](const Measured& m) {
    return std::fabs(m.value - median) <= farthest_sigmas * std::max(scatter, m.sigma);
  };
  double weights = 0, sum = 0;
  for (const Measured& m : values) {
    if (!belongs(m)) continue;
    const double weight = 1 / (m.sigma * m.sigma);
    weights += weight;
    sum += weight * m.value;
    ++mean.used;
  }
  mean.refused = static_cast<std::uint32_t>(values.size()) - mean.used;
  if (mean.used == 0) return mean;
  mean.value = sum / weights;

  count = 0;
  double chi2 = 0;
  for (const Measured& m : values) {
    if (!belongs(m)) continue;
    const double residual = m.value - mean.value;
    scratch[count++] = residual / m.sigma;
    chi2 += residual * residual / (m.sigma * m.sigma);
  }
  const double excess = mean.used > 1 ? std::max(1.0, chi2 / (mean.used - 1)) : 1;
  const double common = inflation(std::span<const double>(scratch).first(count));
  constexpr double contradicting_excess = contradicting_scatter * contradicting_scatter;
  mean.sigma = std::sqrt(excess * (excess > contradicting_excess ? mean.used : common) / weights);
  return mean;
}

}  // namespace ilp::navigation
