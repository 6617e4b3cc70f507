// Scores the merged elevation map of a strip against the true heights.
#pragma once

#include <optional>
#include <vector>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/tools/score/depth_score.hpp"
#include "sim/world/height_grid.hpp"

namespace ilp::score {

/// Median height error of the cells in a slice across the track.
struct HeightProfilePoint {
  double distance = 0;  ///< along the track's main direction from the strip's first keyframe, truth's unit
  double error = 0;     ///< truth's unit, positive: too high
  std::size_t cells = 0;
};

struct HeightScore {
  double flying_height = 0;            ///< truth's unit
  std::size_t covered = 0;             ///< cells with a height; error.count of them have a true height
  ErrorPercent error;                  ///< aligned by the strip's similarity
  std::optional<ErrorPercent> metric;  ///< aligned with the scale as flown; empty unless metric
  /// Height errors in the truth's unit on the grid of the true heights; NaN where not compared. The merged heights are
  /// interpolated along the strip's z axis, so that the map has no holes. The statistics are those of the merged cells
  /// instead.
  host::Raster<float> error_map;
  std::vector<HeightProfilePoint> profile;     ///< in the order of distance; shows a bow of the ground
  std::vector<float> percent, metric_percent;  ///< all errors, for statistics of the flight
};

/// Aligns every merged cell to the truth and compares its height with the true height at the aligned position.
/// `centres` are the true positions of the strip's keyframes in order of flight.
[[nodiscard]] HeightScore score_heights(const map::GroundGrid& grid, const AlignedStrip& strip,
                                        const world::HeightGrid& truth, const std::vector<Vec3>& centres,
                                        double flying_height);

}  // namespace ilp::score
