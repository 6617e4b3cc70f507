// How visible the borders of keyframes are in a map.
#pragma once

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// Root mean square of the second difference along rows and columns. A sample is at a border if the five cells about it
/// come from different keyframes, and elsewhere if they come from one. Samples with an empty cell are left out, and so
/// are the outermost two cells of every tile.
struct Roughness {
  std::uint64_t border_samples = 0, other_samples = 0;
  double border = 0, other = 0;

  /// 0 without a border.
  [[nodiscard]] double ratio() const { return border_samples > 0 && other > 0 ? border / other : 0; }
};

struct SeamMeasure {
  Roughness height;  ///< in cells: a second difference of 1 is a slope that changes by 45 degrees
  Roughness grey;    ///< of the orthoimage, grey values
  /// Of the orthoimage, grey values: root mean square of the difference between the means of 8 cells on both sides of
  /// 8 more, where these 24 cells come from two keyframes that meet among the 8 in the middle; elsewhere those of one
  /// keyframe 16 cells before and behind along the same row or column, since borders lie on rougher ground than most.
  Roughness grey_step;
};

/// Reads every tile once, but for those whose sums `kept` has.
[[nodiscard]] SeamMeasure measure_seams(const Mosaic& mosaic, intake::ResultCache* kept = nullptr);

}  // namespace ilp::map
