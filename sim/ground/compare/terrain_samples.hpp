// Samples cells of the map as points in the common frame, with their pixels in the other model.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/compare/height_model.hpp"
#include "sim/ground/compare/model_frames.hpp"

namespace ilp::compare {

/// Derivatives of column and row of the other model by x and y of the common frame, pixels per unit.
struct PixelScale {
  double column_x = 0, column_y = 0, row_x = 0, row_y = 0;
  /// Side of a pixel in units of the common frame.
  [[nodiscard]] double pixel() const;
};
/// The scale at (x, y). `step`: side of a cell there. NaN if the point cannot be transformed.
[[nodiscard]] PixelScale pixel_scale(const ModelFrames& frames, double x, double y, double step);

struct TerrainSample {
  Vec3 place = Vec3::Zero();   ///< position in the common frame
  double column = 0, row = 0;  ///< position in the other model, px
  std::uint32_t scale = 0;     ///< index in TerrainSamples::scales
  std::uint8_t half = 0;       ///< 0 or 1: colour of its field on a chessboard of 8 x 8 fields over the map
};

struct TerrainSamples {
  std::vector<TerrainSample> cells;
  std::vector<PixelScale> scales;
  double cell = 0;  ///< side of a reduced cell of the map, units of the common frame
};

/// Takes at most about `most` samples, evenly distributed over the reduced map.
[[nodiscard]] TerrainSamples take_samples(HeightModel& map, const ModelFrames& frames, std::size_t most);

/// Centre of a reduced cell, in the map's coordinates.
[[nodiscard]] Vec3 map_point(const HeightModel& map, std::int32_t column, std::int32_t row, double height);
/// Side of a pixel of the file, in the map's coordinates.
[[nodiscard]] double side_of_pixel(const HeightModel& map);

}  // namespace ilp::compare
