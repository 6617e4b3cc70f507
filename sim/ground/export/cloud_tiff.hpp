// Assembles a Cloud-Optimised GeoTIFF (OGC 21-026) from compressed blocks.
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
  std::vector<std::uint32_t> block_bytes;  ///< size of each compressed block, row by row; 0: no data, nothing stored

  [[nodiscard]] std::int32_t block_columns() const { return (columns + cloud_block_side - 1) / cloud_block_side; }
  [[nodiscard]] std::int32_t block_rows() const { return (rows + cloud_block_side - 1) / cloud_block_side; }
  [[nodiscard]] std::size_t blocks() const {
    return static_cast<std::size_t>(block_columns()) * static_cast<std::size_t>(block_rows());
  }
};

/// The levels of a raster: the raster itself, then overviews, each with half the columns and rows of the one before.
/// The last has one block. block_bytes are 0.
[[nodiscard]] std::vector<CloudLevel> cloud_levels(std::int32_t columns, std::int32_t rows);

/// Returns the bytes of a block, `block_bytes[number]` of them. `level`: 0 is the raster itself. `number`: row by row.
using CloudBlock = std::function<std::vector<std::uint8_t>(std::size_t level, std::size_t number)>;

enum class CloudFormat : std::uint8_t {
  as_needed,  ///< BigTIFF if the file may exceed 4 GiB, else classic TIFF
  big,
};

/// Writes the file. `head`: a GeoTIFF file of GDAL with one tile of 256 x 256, from which all tags are copied (type,
/// compression, georeference, descriptions), except those of size and blocks. `block` is called once for each block
/// that is not empty. Throws std::runtime_error if `head` is not such a file, or a block has another size.
void write_cloud_tiff(std::span<const std::uint8_t> head, const std::vector<CloudLevel>& levels,
                      const CloudBlock& block, std::ostream& out, CloudFormat format = CloudFormat::as_needed);

}  // namespace ilp::exports
