// Scores the overlaps that the flight has measured and achieved against the true overlaps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// The overlap of a frame with the keyframe before it, as the overlap checker measured it.
struct MeasuredOverlap {
  std::string keyframe, frame;  ///< names
  double measured = 0;          ///< overlap of footprints from the flight
  double true_footprint = 0;    ///< world::true_footprint_overlap(keyframe, frame)
  double true_overlap = 0;      ///< world::true_overlap(keyframe, frame): without hidden ground
};

/// The true overlap of two consecutive keyframes of a strip.
struct AchievedOverlap {
  std::int64_t previous_id = 0, keyframe_id = 0;
  double true_overlap = 0;  ///< share of the previous keyframe's area
};

struct OverlapScore {
  double target = unknown;                ///< that the flight aims at
  std::vector<MeasuredOverlap> measured;  ///< in the order of frames; those with the verdict ok and true frames
  std::vector<AchievedOverlap> achieved;  ///< in the order of keyframes

  double true_mean = unknown, true_std = unknown;      ///< of `achieved`
  double error_bias = unknown;                         ///< median of measured minus true footprint overlap
  double error_median = unknown, error_p95 = unknown;  ///< of the absolute values of the same
};

/// `target` is 0 if not known. Frames that are not keyframes have names in the onboard database only; without it they
/// are left out.
[[nodiscard]] OverlapScore score_overlaps(const intake::Flight& flight, double target, TrueFrames& truth);

}  // namespace ilp::score
