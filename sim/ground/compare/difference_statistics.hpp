// Computes exact statistics of height differences in a raster of any size, in little memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace ilp::compare {

/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
inline constexpr double nmad_factor = 1.4826;

struct HeightHistogram {
  double low = 0, width = 0;          ///< lower end of the first bin, and width of each bin; metres
  std::vector<std::uint64_t> counts;  ///< the middle bin contains the median
  std::uint64_t outside = 0;          ///< values outside all bins
};

/// The measures that J. Hoehle and M. Hoehle recommend (ISPRS Journal 64(4), 2009), metres; NaN without values.
struct DifferenceStatistics {
  std::uint64_t count = 0;
  double mean = 0, median = 0, deviation = 0, rmse = 0;
  double nmad = 0;    ///< normalised median absolute deviation
  double abs_68 = 0;  ///< 68.3 % quantile of the absolute differences
  double abs_95 = 0;  ///< 95 % quantile of the absolute differences
  double least = 0, most = 0;
  HeightHistogram histogram;
};

/// Passes all values to its argument, in parts. Each call passes the same values in the same order.
using ValueScan = std::function<void(const std::function<void(std::span<const float>)>&)>;
/// Statistics of the finite values. Quantiles are as in host::percentile. Calls `scan` several times.
[[nodiscard]] DifferenceStatistics statistics_of(const ValueScan& scan);
/// Statistics of the first band of a raster file. Throws std::runtime_error if it cannot be read.
[[nodiscard]] DifferenceStatistics statistics_of(const std::filesystem::path& raster);

}  // namespace ilp::compare
