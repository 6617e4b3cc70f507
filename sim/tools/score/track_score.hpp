// Scores the depths of the ground along the track: share, accuracy, and sampling at the end of the flight.
#pragma once

#include <map>

#include "sim/tools/score/depth_score.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// Each keyframe contributes the same grid of ground points, in the inner half of its image in x and in y. A point is
/// mapped if any keyframe sees it at a pixel with a depth. The nearest of these keyframes, which samples the point most
/// finely, counts.
struct TrackScore {
  std::size_t points = 0, mapped = 0;
  double error_median_percent = unknown;  ///< error of the depth, % of the true depth
  /// Sampling at the end: the distance (true depth) from which a point of the last keyframe was mapped, divided by its
  /// distance from the last keyframe. Median over the mapped points of the last keyframe.
  double landing_ratio = unknown;

  [[nodiscard]] double mapped_share() const {
    return points == 0 ? unknown : static_cast<double>(mapped) / static_cast<double>(points);
  }
};

/// `strips` are those that could be aligned to the truth, by id.
[[nodiscard]] TrackScore score_track(const intake::Flight& flight, const std::map<std::int64_t, AlignedStrip>& strips,
                                     TrueFrames& truth);

}  // namespace ilp::score
