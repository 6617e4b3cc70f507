// Compresses a block of a raster file, 256 x 256 samples, and reduces it to half the size for the overviews.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sim/ground/export/cloud_tiff.hpp"

namespace ilp::exports {

inline constexpr std::size_t block_samples =
    static_cast<std::size_t>(cloud_block_side) * static_cast<std::size_t>(cloud_block_side);

/// Statistics of the samples that have a value.
struct SampleStatistics {
  std::uint64_t count = 0;
  double least = 0, most = 0, mean = 0, squares = 0;  ///< squares: sum of squared distances from the mean

  /// Combines the statistics of two sets of samples.
  void add(const SampleStatistics& other);
};

// Types of samples: `nothing` is the value without data; `averaged` says whether overviews have the mean of four
// samples.

struct HeightSample {
  using Type = float;
  static constexpr bool averaged = true;
  static constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  static bool has_value(float sample) { return std::isfinite(sample); }
};
struct CountSample {
  using Type = std::uint16_t;
  static constexpr bool averaged = false;  ///< overviews have the first sample with a value
  static constexpr std::uint16_t nothing = 65535;
  static bool has_value(std::uint16_t sample) { return sample != nothing; }
};
struct GreySample {
  using Type = std::uint8_t;
  static constexpr bool averaged = true;
  static constexpr std::uint8_t nothing = 0;
  static bool has_value(std::uint8_t sample) { return sample != nothing; }
};

struct RasterBlock {
  SampleStatistics statistics;
  std::vector<std::uint8_t> coded;   ///< with TIFF's predictor, deflated; empty if no sample has a value
  std::vector<std::uint8_t> halved;  ///< the block reduced to 128 x 128 samples, deflated; empty as `coded`
};

/// Compresses 256 x 256 samples, given row by row.
template <typename Sample>
[[nodiscard]] RasterBlock raster_block(const std::vector<typename Sample::Type>& samples);

/// Decompresses the reduced samples of a block into a quarter of the overview's block. `right`, `down`: 0 or 1,
/// position of the quarter. Throws std::runtime_error if the bytes are damaged.
template <typename Sample>
void put_halved(std::span<const std::uint8_t> halved, std::int32_t right, std::int32_t down,
                std::vector<typename Sample::Type>& samples);

[[nodiscard]] std::vector<std::uint8_t> bytes_of(const RasterBlock& block);
/// Reads back what bytes_of wrote; none if the bytes are damaged.
[[nodiscard]] std::optional<RasterBlock> raster_block_from(std::span<const std::uint8_t> bytes);

}  // namespace ilp::exports
