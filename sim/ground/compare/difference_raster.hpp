// Writes the height difference of every cell of the map as a GeoTIFF, block by block.
#pragma once

#include <cstdint>
#include <filesystem>

#include "sim/ground/compare/height_model.hpp"
#include "sim/ground/compare/model_frames.hpp"

namespace ilp::compare {

/// Numbers of cells of the map. Each cell is in one of the first five.
struct CellCounts {
  std::uint64_t without_height = 0;  ///< no height in the map
  std::uint64_t outside = 0;         ///< outside the other model
  std::uint64_t without_other = 0;   ///< no height in the other model
  std::uint64_t steep = 0;           ///< steeper than allowed
  std::uint64_t compared = 0;
  struct Within {
    std::uint64_t stated = 0;        ///< compared cells with an estimated error
    std::uint64_t one = 0, two = 0;  ///< of these, cells with a difference within one and two estimated sigmas
  };
  Within sigma;     ///< by the total estimated error
  Within matching;  ///< by the error from matching alone
};

/// The map's heights and the differences, reduced for pictures; metres; NaN: no value.
struct DifferenceOverview {
  host::Raster<float> height, difference;
  double cell = 0;  ///< side of a cell, metres
};

struct DifferenceResult {
  CellCounts counts;
  DifferenceOverview overview;
  double other_cell = 0;  ///< side of the other model's cells as compared, metres; 0: nothing was compared
};

/// Rasters of estimated errors with the map's size and unit; null: there is none.
struct EstimatedErrors {
  HeightModel* sigma = nullptr;
  HeightModel* matching = nullptr;
};

/// Writes map minus other model, metres, to `path`. The raster has the map's cells, transformed by `moved` in the
/// common frame. Cells that are not compared are NaN. Throws std::runtime_error if the file cannot be written.
[[nodiscard]] DifferenceResult write_difference(HeightModel& map, const EstimatedErrors& stated, HeightModel& other,
                                                const ModelFrames& frames, const host::Similarity3& moved,
                                                double max_slope_rad, const std::filesystem::path& path);

}  // namespace ilp::compare
