// How much of the ground below the track came down, how exactly, and how finely where the flight ends.
#pragma once

#include <map>

#include "sim/tools/score/depth_score.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// Points of the ground in the inner half of every keyframe's image, each way: every keyframe counts alike, whatever
/// its height. A point is mapped if some keyframe has a depth where it appears there; of several the finest counts.
struct TrackScore {
  std::size_t points = 0, mapped = 0;
  double error_median_percent = unknown;  ///< of the depth, in per cent of the distance at which the point was seen
  /// Distance at which the ground in the inner half of the last keyframe was mapped over the distance of that keyframe:
  /// median over its mapped points.
  double landing_ratio = unknown;

  [[nodiscard]] double mapped_share() const {
    return points == 0 ? unknown : static_cast<double>(mapped) / static_cast<double>(points);
  }
};

/// `strips` that lie on the truth, by id.
[[nodiscard]] TrackScore score_track(const intake::Flight& flight, const std::map<std::int64_t, AlignedStrip>& strips,
                                     TrueFrames& truth);

}  // namespace ilp::score
