// The overlap that was measured and achieved, against the true one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// A frame that the overlap checker compared with the keyframe before it.
struct MeasuredOverlap {
  std::string keyframe, frame;  ///< names
  double measured = 0;          ///< of footprints, as the flight measures it
  double true_footprint = 0;    ///< world::true_footprint_overlap of the keyframe in the frame
  double true_overlap = 0;      ///< world::true_overlap: without what is hidden
};

/// Two keyframes in a row of the same strip.
struct AchievedOverlap {
  std::int64_t previous_id = 0, keyframe_id = 0;
  double true_overlap = 0;  ///< share of the previous keyframe's ground
};

struct OverlapScore {
  double target = unknown;
  std::vector<MeasuredOverlap> measured;  ///< by frame: those with a trustworthy answer and a true frame
  std::vector<AchievedOverlap> achieved;  ///< by keyframe

  double true_mean = unknown, true_std = unknown;      ///< of `achieved`
  double error_bias = unknown;                         ///< median of measured minus true footprint overlap
  double error_median = unknown, error_p95 = unknown;  ///< of the absolute errors
};

/// Frames other than keyframes are known by name only with the onboard database.
[[nodiscard]] OverlapScore score_overlaps(const intake::Flight& flight, double target, TrueFrames& truth);

}  // namespace ilp::score
