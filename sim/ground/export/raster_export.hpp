// Writes the map of a strip as Cloud-Optimised GeoTIFF files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// Writes height, sigma, sigma-matching, count, ortho and laid SUFFIX .tif, and returns the names of the files. All
/// have the map's grid, a nodata value, overviews, statistics, and unit and description of the band:
/// - height, f32: height in map coordinates of `place`; NaN: no height
/// - sigma, f32: standard deviation of the height with all components (height_error.hpp); NaN: unknown
/// - sigma-matching, f32: its component from matching; NaN: unknown. Neither file is written if all values are unknown
/// - count, u16: number of keyframes whose surface covers the cell; 0: on a closed seam; 65535: no height
/// - ortho, u8: grey value of the orthoimage, 1 to 255; 0: no height
/// - laid, u8: grey value of ground without a height, on interpolated heights, 1 to 255; 0: no such ground. The file is
///   not written if there is none at all
/// Memory does not grow with the map. A file appears when it is complete. The same map gives the same bytes. `kept`
/// caches blocks by the digests of their tiles, so that unchanged blocks are neither read nor compressed again; it may
/// be null. Throws std::runtime_error.
std::vector<std::string> write_rasters(const map::Mosaic& mosaic, const Georeference& place, const std::string& suffix,
                                       const std::filesystem::path& folder, intake::ResultCache* kept = nullptr);

/// Reads the orthoimage that write_rasters wrote, reduced to at most `max_side` columns and rows; it covers the whole
/// map. Throws std::runtime_error.
[[nodiscard]] host::Raster<std::uint8_t> read_ortho(const std::filesystem::path& file, std::int32_t max_side);

}  // namespace ilp::exports
