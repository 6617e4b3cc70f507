// Measures how visible the borders between keyframes are in a map.
#pragma once

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// RMS of second differences along rows and columns. A sample is five cells in a row or column. It is a border sample
/// if its cells come from different keyframes, and another sample if all come from one keyframe. Samples with an empty
/// cell are left out. No sample crosses the edge of a tile.
struct Roughness {
  std::uint64_t border_samples = 0, other_samples = 0;
  double border = 0, other = 0;  ///< RMS of the border samples and of the other samples

  /// Ratio of `border` to `other`; 0 if there is no border sample or `other` is 0.
  [[nodiscard]] double ratio() const { return border_samples > 0 && other > 0 ? border / other : 0; }
};

struct SeamMeasure {
  Roughness height;  ///< roughness of heights, in cells: 1 is a slope that changes from 0 to 45 degrees
  Roughness grey;    ///< roughness of the orthoimage, grey values
  /// Steps in the orthoimage, grey values. A sample is 24 cells in a row or column, and its step is the mean of the
  /// last 8 minus the mean of the first 8. `border`: RMS of samples from two keyframes that meet in the middle 8 cells.
  /// `other`: RMS of samples from one keyframe, 16 cells before or after a border sample: ground at borders is rougher
  /// than most, so only ground near a border is compared with it.
  Roughness grey_step;
};

/// Measures the whole map. Reads every tile once, except those whose sums `kept` has; `kept` may be null.
[[nodiscard]] SeamMeasure measure_seams(const Mosaic& mosaic, intake::ResultCache* kept = nullptr);

}  // namespace ilp::map
