// Cells of the map as points in the common frame, with the pixels of the other model below them.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/compare/height_model.hpp"
#include "sim/ground/compare/model_frames.hpp"

namespace ilp::compare {

/// Pixels of the other model per unit of the common frame.
struct PixelScale {
  double column_x = 0, column_y = 0, row_x = 0, row_y = 0;
  /// Side of a pixel in units of the common frame.
  [[nodiscard]] double pixel() const;
};
/// Near x, y; `step` is the side of a cell there. Without numbers where there is no way.
[[nodiscard]] PixelScale pixel_scale(const ModelFrames& frames, double x, double y, double step);

struct TerrainSample {
  Vec3 place = Vec3::Zero();   ///< common frame
  double column = 0, row = 0;  ///< of the other model
  std::uint32_t scale = 0;     ///< index in TerrainSamples::scales
  std::uint8_t half = 0;       ///< 0 or 1: field of a chessboard of 8 x 8 on the map
};

struct TerrainSamples {
  std::vector<TerrainSample> cells;
  std::vector<PixelScale> scales;
  double cell = 0;  ///< side of a reduced cell of the map, common frame
};

/// Evenly over the reduced map, at most about `most`.
[[nodiscard]] TerrainSamples take_samples(HeightModel& map, const ModelFrames& frames, std::size_t most);

/// Centre of the reduced cell, in the map's coordinates.
[[nodiscard]] Vec3 map_point(const HeightModel& map, std::int32_t column, std::int32_t row, double height);
/// Side of a pixel of the file, in the map's coordinates.
[[nodiscard]] double side_of_pixel(const HeightModel& map);

}  // namespace ilp::compare
