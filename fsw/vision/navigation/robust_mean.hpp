// Location of measurements with outliers: the values far from the median are left out, the others are averaged by
// their sigmas (F. R. Hampel, "The Influence Curve and its Role in Robust Estimation", 1974).
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/fixed_vector.hpp"

namespace ilp::navigation {

inline constexpr std::size_t max_values = 128;
/// Of a normal distribution: sigma over the median absolute deviation.
inline constexpr double sigma_per_mad = 1.4826;

/// Values that scatter by so many times what they state are no errors that a mean takes away: nobody knows which is
/// right.
inline constexpr double contradicting_scatter = 4;

struct Measured {
  double value = 0;
  double sigma = 0;  ///< one sigma of the value
};
using Measurements = FixedVector<Measured, max_values>;

struct RobustMean {
  double value = 0;
  double sigma = 0;  ///< 0 without any value
  std::uint32_t used = 0;
  std::uint32_t refused = 0;
};

/// The sigma follows from the scatter of the values, or from their own sigmas where these are larger. Neighbours in
/// the list are neighbours in time: errors that change slowly count as fewer values. Where the scatter is more than
/// four times what the values state, it is the sigma, and no mean makes it smaller.
[[nodiscard]] RobustMean robust_mean(const Measurements& values);

/// By how much the errors of neighbours agree: the variance of their mean is this many times larger than that of
/// independent errors.
[[nodiscard]] double inflation(std::span<const double> residuals);

/// Median, which is reordered; 0 without any value.
[[nodiscard]] double median_of(std::span<double> values);

}  // namespace ilp::navigation
