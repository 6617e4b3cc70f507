// Mean of measurements with outliers: values far from the median are excluded, the others are weighted by their inverse
// variances (F. R. Hampel, "The Influence Curve and its Role in Robust Estimation", 1974).
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/fixed_vector.hpp"

namespace ilp::navigation {

inline constexpr std::size_t max_values = 128;
/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
inline constexpr double sigma_per_mad = 1.4826;

/// If values scatter by more than this multiple of their own sigmas, they contradict each other: averaging does not
/// reduce the error.
inline constexpr double contradicting_scatter = 4;

struct Measured {
  double value = 0;
  double sigma = 0;  ///< standard deviation of the value, > 0
};
using Measurements = FixedVector<Measured, max_values>;

struct RobustMean {
  double value = 0;
  double sigma = 0;  ///< standard deviation; 0 if no value was used
  std::uint32_t used = 0;
  std::uint32_t refused = 0;  ///< outliers
};

/// The sigma of the mean follows from the scatter of the values, or from their own sigmas if these are larger. The
/// values are in order of time: if the errors of neighbours are correlated, they count as fewer values. If the scatter
/// is above contradicting_scatter times the values' own sigmas, the sigma is the scatter itself.
[[nodiscard]] RobustMean robust_mean(const Measurements& values);

/// Factor by which the correlation of neighbouring residuals increases the variance of their mean, compared with
/// independent errors.
[[nodiscard]] double inflation(std::span<const double> residuals);

/// Median; reorders `values`. 0 if there are none.
[[nodiscard]] double median_of(std::span<double> values);

}  // namespace ilp::navigation
