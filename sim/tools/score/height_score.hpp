// The merged elevation map of a strip against the true heights.
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
  std::size_t covered = 0;             ///< cells with a height; error.count of them lie where the truth is known
  ErrorPercent error;                  ///< of the flying height, strip's similarity
  std::optional<ErrorPercent> metric;  ///< scale as flown
  /// Truth's unit, on the grid of the true heights: the same for all strips. NaN where not compared. Cells are
  /// looked up along the strip's own z axis, so that the map has no holes; the statistics are of the merged cells.
  host::Raster<float> error_map;
  std::vector<HeightProfilePoint> profile;     ///< by distance: shows a bow of the ground
  std::vector<float> percent, metric_percent;  ///< all errors, for the flight's sums
};

/// Every cell is laid onto the truth and compared with the true height where it then stands. `centres`: the true
/// positions of the strip's keyframes, in order.
[[nodiscard]] HeightScore score_heights(const map::GroundGrid& grid, const AlignedStrip& strip,
                                        const world::HeightGrid& truth, const std::vector<Vec3>& centres,
                                        double flying_height);

}  // namespace ilp::score
