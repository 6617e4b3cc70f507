// One block of a raster file, 256 x 256 samples, and the same at half the size for the overviews.
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

/// Of the samples that have a value.
struct SampleStatistics {
  std::uint64_t count = 0;
  double least = 0, most = 0, mean = 0, squares = 0;  ///< squares: sum of squared distances from the mean

  /// As if the samples of both were one set.
  void add(const SampleStatistics& other);
};

/// How samples of a type are stored, and which one stands for nothing.
struct HeightSample {
  using Type = float;
  static constexpr bool averaged = true;
  static constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  static bool has_value(float sample) { return std::isfinite(sample); }
};
struct CountSample {
  using Type = std::uint16_t;
  static constexpr bool averaged = false;  ///< an overview has the first one that has a value
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
  std::vector<std::uint8_t> coded;   ///< with TIFF's predictor, deflated; empty where no sample has a value
  std::vector<std::uint8_t> halved;  ///< 128 x 128 samples, deflated; empty likewise
};

/// Of 256 x 256 samples, row by row.
template <typename Sample>
[[nodiscard]] RasterBlock raster_block(const std::vector<typename Sample::Type>& samples);

/// Puts the halved samples of a block into a quarter of a block: 0 or 1 to the right and downwards. Throws
/// std::runtime_error when they are damaged.
template <typename Sample>
void put_halved(std::span<const std::uint8_t> halved, std::int32_t right, std::int32_t down,
                std::vector<typename Sample::Type>& samples);

[[nodiscard]] std::vector<std::uint8_t> bytes_of(const RasterBlock& block);
/// None when the bytes are not what bytes_of gave.
[[nodiscard]] std::optional<RasterBlock> raster_block_from(std::span<const std::uint8_t> bytes);

}  // namespace ilp::exports
