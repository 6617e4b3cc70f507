// Statistics of height differences in a raster of any size, exact and in little memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace ilp::compare {

/// From a median distance to the sigma of a normal distribution.
inline constexpr double nmad_factor = 1.4826;

struct HeightHistogram {
  double low = 0, width = 0;          ///< of the first bin, metres
  std::vector<std::uint64_t> counts;  ///< the middle bin holds the median
  std::uint64_t outside = 0;
};

/// As J. Hoehle and M. Hoehle recommend (ISPRS Journal 64(4), 2009), metres; NaN without values.
struct DifferenceStatistics {
  std::uint64_t count = 0;
  double mean = 0, median = 0, deviation = 0, rmse = 0;
  double nmad = 0;    ///< 1.4826 times the median distance from the median
  double abs_68 = 0;  ///< 68.3 % of the absolute differences are below
  double abs_95 = 0;  ///< 95 %
  double least = 0, most = 0;
  HeightHistogram histogram;
};

/// Calls with all values, in pieces and in one order, as often as it is asked.
using ValueScan = std::function<void(const std::function<void(std::span<const float>)>&)>;
/// Values that are not finite are left out. Quantiles are values of the sample, as host::percentile gives them.
[[nodiscard]] DifferenceStatistics statistics_of(const ValueScan& scan);
/// Of the first band of a raster file. Throws std::runtime_error when it cannot be read.
[[nodiscard]] DifferenceStatistics statistics_of(const std::filesystem::path& raster);

}  // namespace ilp::compare
