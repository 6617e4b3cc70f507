// The height difference of every cell of the map, as a GeoTIFF that grows block by block.
#pragma once

#include <cstdint>
#include <filesystem>

#include "sim/ground/compare/height_model.hpp"
#include "sim/ground/compare/model_frames.hpp"

namespace ilp::compare {

/// Cells of the map, each counted once.
struct CellCounts {
  std::uint64_t without_height = 0;  ///< in the map
  std::uint64_t outside = 0;         ///< of the other model
  std::uint64_t without_other = 0;   ///< the other model has no value there
  std::uint64_t steep = 0;           ///< steeper than allowed
  std::uint64_t compared = 0;
  struct Within {
    std::uint64_t stated = 0;        ///< compared, with an estimated error
    std::uint64_t one = 0, two = 0;  ///< difference within one and two estimated sigmas
  };
  Within sigma;     ///< all parts of the error
  Within matching;  ///< that of matching alone
};

/// The map and its difference made smaller, for pictures; NaN where there is none.
struct DifferenceOverview {
  host::Raster<float> height, difference;
  double cell = 0;  ///< side of a cell, metres
};

struct DifferenceResult {
  CellCounts counts;
  DifferenceOverview overview;
  double other_cell = 0;  ///< side of the cells of the other model, metres; 0 where nothing was compared
};

/// Rasters of the map's size and unit, or null.
struct EstimatedErrors {
  HeightModel* sigma = nullptr;
  HeightModel* matching = nullptr;
};

/// Map minus other model, metres, written to `path` on the map's own cells, where `moved` (common frame) puts them.
/// Cells that are not compared have no value. Throws std::runtime_error when the file cannot be written.
[[nodiscard]] DifferenceResult write_difference(HeightModel& map, const EstimatedErrors& stated, HeightModel& other,
                                                const ModelFrames& frames, const host::Similarity3& moved,
                                                double max_slope_rad, const std::filesystem::path& path);

}  // namespace ilp::compare
