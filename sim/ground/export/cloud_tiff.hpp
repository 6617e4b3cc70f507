// A Cloud-Optimised GeoTIFF (OGC 21-026) put together from blocks that are compressed already.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <vector>

namespace ilp::exports {

inline constexpr std::int32_t cloud_block_side = 256;

/// The raster itself, or an overview of it.
struct CloudLevel {
  std::int32_t columns = 0, rows = 0;
  std::vector<std::uint32_t> block_bytes;  ///< row by row; 0: nothing there, and the reader sees the value for it

  [[nodiscard]] std::int32_t block_columns() const { return (columns + cloud_block_side - 1) / cloud_block_side; }
  [[nodiscard]] std::int32_t block_rows() const { return (rows + cloud_block_side - 1) / cloud_block_side; }
  [[nodiscard]] std::size_t blocks() const {
    return static_cast<std::size_t>(block_columns()) * static_cast<std::size_t>(block_rows());
  }
};

/// The raster and its overviews, each half as large, until one block holds all. No bytes yet.
[[nodiscard]] std::vector<CloudLevel> cloud_levels(std::int32_t columns, std::int32_t rows);

/// Gives the bytes of a block, as many as `block_bytes` says. `number`: row by row.
using CloudBlock = std::function<std::vector<std::uint8_t>(std::size_t level, std::size_t number)>;

enum class CloudFormat : std::uint8_t {
  as_needed,  ///< BigTIFF where the file passes 4 GiB, classic TIFF otherwise
  big,
};

/// `head` is a GeoTIFF file of GDAL's with one tile of 256 x 256 that says everything else of the raster: type,
/// compression, place, descriptions. What it says stands in the file, but for the size and the blocks. Every block is
/// requested once. Throws std::runtime_error when `head` is no such file.
void write_cloud_tiff(std::span<const std::uint8_t> head, const std::vector<CloudLevel>& levels,
                      const CloudBlock& block, std::ostream& out, CloudFormat format = CloudFormat::as_needed);

}  // namespace ilp::exports
