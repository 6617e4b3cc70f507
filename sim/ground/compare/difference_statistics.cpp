#include "sim/ground/compare/difference_statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sim/host/gdal_session.hpp"

namespace ilp::compare {
namespace {

constexpr std::size_t keys = 1U << 16U;
constexpr int bins = 81;

/// Integers in the order of the numbers.
std::uint32_t key_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}
float value_of(std::uint32_t key) {
  return std::bit_cast<float>((key & 0x80000000U) != 0 ? key & 0x7FFFFFFFU : ~key);
}

using Change = std::function<float(float)>;

/// Counts by the upper half of the key, then, within one upper half, by the lower half.
std::vector<std::uint64_t> counts_by_key(const ValueScan& scan, const Change& change, std::int64_t upper) {
  std::vector<std::uint64_t> counts(keys);
  scan([&](std::span<const float> values) {
    for (const float value : values) {
      if (!std::isfinite(value)) continue;
      const std::uint32_t key = key_of(change(value));
      if (upper < 0) {
        ++counts[key >> 16U];
      } else if (key >> 16U == static_cast<std::uint32_t>(upper)) {
        ++counts[key & 0xFFFFU];
      }
    }
  });
  return counts;
}

/// The key whose value has `rank` values below it, and how many are below the key.
std::pair<std::uint32_t, std::uint64_t> find_rank(const std::vector<std::uint64_t>& counts, std::uint64_t rank) {
  std::uint64_t below = 0;
  for (std::uint32_t key = 0; key < counts.size(); ++key) {
    if (below + counts[key] > rank) return {key, below};
    below += counts[key];
  }
  return {static_cast<std::uint32_t>(counts.size() - 1), below};
}

std::vector<double> quantiles(const ValueScan& scan, const Change& change, std::uint64_t count,
                              std::initializer_list<double> shares) {
  const std::vector<std::uint64_t> uppers = counts_by_key(scan, change, -1);
  std::vector<double> result;
  for (const double share : shares) {
    const auto rank = static_cast<std::uint64_t>(share * static_cast<double>(count - 1) + 0.5);
    const auto [upper, below] = find_rank(uppers, rank);
    const auto lower = find_rank(counts_by_key(scan, change, upper), rank - below).first;
    result.push_back(double{value_of(upper << 16U | lower)});
  }
  return result;
}

void add_moments(const ValueScan& scan, DifferenceStatistics& s) {
  double sum = 0, squares = 0;
  s.least = std::numeric_limits<double>::infinity();
  s.most = -s.least;
  scan([&](std::span<const float> values) {
    for (const float value : values) {
      if (!std::isfinite(value)) continue;
      const double v = value;
      ++s.count;
      sum += v;
      squares += v * v;
      s.least = std::min(s.least, v);
      s.most = std::max(s.most, v);
    }
  });
  const auto n = static_cast<double>(s.count);
  s.mean = sum / n;
  s.rmse = std::sqrt(squares / n);
  double about_mean = 0;
  scan([&](std::span<const float> values) {
    for (const float value : values) {
      if (std::isfinite(value)) about_mean += (double{value} - s.mean) * (double{value} - s.mean);
    }
  });
  s.deviation = std::sqrt(about_mean / n);
}

HeightHistogram histogram_of(const ValueScan& scan, double median, double half_width) {
  HeightHistogram histogram;
  histogram.width = 2 * half_width / bins;
  histogram.low = median - half_width;
  histogram.counts.assign(bins, 0);
  scan([&](std::span<const float> values) {
    for (const float value : values) {
      if (!std::isfinite(value)) continue;
      const double at = std::floor((double{value} - histogram.low) / histogram.width);
      if (at >= 0 && at < bins) {
        ++histogram.counts[static_cast<std::size_t>(at)];
      } else {
        ++histogram.outside;
      }
    }
  });
  return histogram;
}

}  // namespace

DifferenceStatistics statistics_of(const ValueScan& scan) {
  DifferenceStatistics s;
  add_moments(scan, s);
  if (s.count == 0) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    s.mean = s.median = s.deviation = s.rmse = s.nmad = s.abs_68 = s.abs_95 = s.least = s.most = none;
    return s;
  }
  s.median = quantiles(scan, [](float v) { return v; }, s.count, {0.5})[0];
  const auto median = static_cast<float>(s.median);
  s.nmad = nmad_factor * quantiles(scan, [median](float v) { return std::fabs(v - median); }, s.count, {0.5})[0];
  const std::vector<double> absolute = quantiles(scan, [](float v) { return std::fabs(v); }, s.count, {0.683, 0.95});
  s.abs_68 = absolute[0];
  s.abs_95 = absolute[1];
  const double spread = s.nmad > 0 ? 4 * s.nmad : std::max({s.median - s.least, s.most - s.median, 1e-3});
  s.histogram = histogram_of(scan, s.median, spread);
  return s;
}

DifferenceStatistics statistics_of(const std::filesystem::path& raster) {
  const host::GdalSession session;
  const host::Dataset file(GDALDataset::Open(raster.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!file) throw host::gdal_error(raster.string() + ": cannot be read");
  GDALRasterBand& band = *file->GetRasterBand(1);
  constexpr std::int32_t rows_at_once = 256;
  const std::int32_t columns = file->GetRasterXSize(), rows = file->GetRasterYSize();
  return statistics_of([&](const std::function<void(std::span<const float>)>& visit) {
    std::vector<float> values(static_cast<std::size_t>(columns) * rows_at_once);
    for (std::int32_t row = 0; row < rows; row += rows_at_once) {
      const std::int32_t count = std::min(rows_at_once, rows - row);
      if (band.RasterIO(GF_Read, 0, row, columns, count, values.data(), columns, count, GDT_Float32, 0, 0, nullptr) !=
          CE_None) {
        throw host::gdal_error(raster.string() + ": cannot be read");
      }
      visit({values.data(), static_cast<std::size_t>(columns) * static_cast<std::size_t>(count)});
    }
  });
}

}  // namespace ilp::compare
