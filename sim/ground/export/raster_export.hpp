// The map of a strip as Cloud-Optimised GeoTIFF files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// height, sigma, sigma-matching, count, ortho and laid SUFFIX .tif, all in the map's grid, with nodata, overviews,
/// statistics, and unit and description of the band:
/// - height, f32: of `place`; NaN where nothing was seen
/// - sigma, f32: one sigma of the height, from matching; NaN where it is unknown; no file if it is known nowhere
/// - count, u16: keyframes whose surface covers the cell, 0 on a seam that was closed; 65535 where nothing was seen
/// - ortho, u8: grey value seen from above, from 1; 0 where no height was measured
/// - laid, u8: grey value of ground without a height, laid on interpolated heights, from 1; 0 elsewhere; no file if
///   there is none
/// Memory does not grow with the map. Files appear when they are complete, and the same map gives the same bytes.
/// Blocks are taken from `kept`, and put there, by the digests of the tiles under them: where these have not changed,
/// no tile is read and nothing is compressed. The names of the files written; throws std::runtime_error.
std::vector<std::string> write_rasters(const map::Mosaic& mosaic, const Georeference& place, const std::string& suffix,
                                       const std::filesystem::path& folder, intake::ResultCache* kept = nullptr);

/// The orthoimage that write_rasters left, as a texture of at most `max_side` pixels a side; it covers the whole map.
/// Throws std::runtime_error.
[[nodiscard]] host::Raster<std::uint8_t> read_ortho(const std::filesystem::path& file, std::int32_t max_side);

}  // namespace ilp::exports
