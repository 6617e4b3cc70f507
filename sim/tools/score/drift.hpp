// Errors that grow along a strip: the position error, the scale, and the bow of the heights.
#pragma once

#include <optional>
#include <vector>

#include "sim/tools/score/pose_score.hpp"

namespace ilp::score {

/// In shorter strips the beginning and the end are not distinct.
inline constexpr std::size_t fewest_poses_of_drift = 6;

/// The first quarter of the samples, at least 4, is laid onto the truth by a similarity of positions and attitudes
/// (align_cameras with the flying height as reach). What the later samples are then off by has accumulated.
struct Drift {
  std::size_t aligned_samples = 0;
  std::vector<Vec3> error;  ///< of each sample, truth's axes and unit
  double end_error = 0;     ///< length of the last one
  double percent = 0;       ///< of the distance flown
};
[[nodiscard]] std::optional<Drift> measure_drift(const StripTrack& track);

/// Every step between consecutive samples gives a local scale, estimated over true length. A line is fitted to their
/// logarithms against the distance of the step's middle, weighted by the squared true step (positions of equal
/// error); steps of no length are left out. None for fewer than 5 steps.
struct ScaleDrift {
  std::vector<double> local_scale;  ///< of the steps around each sample, relative to the strip's mean scale
  double percent = 0;               ///< change of the fitted scale from the begin to the end; positive: it grows
};
[[nodiscard]] std::optional<ScaleDrift> measure_scale_drift(const StripTrack& track);

/// Unit and perpendicular, in the truth's world: the track's main direction, and the mean line of sight turned back and
/// made perpendicular to it, so that no axis of the truth's world has to be vertical.
struct TrackAxes {
  Vec3 forward = Vec3::UnitX(), up = Vec3::UnitZ();
};
/// Needs at least one sample.
[[nodiscard]] TrackAxes track_axes(const StripTrack& track);

/// Aligned by align_cameras over the whole strip, the height errors along TrackAxes::up are fitted by
/// h(u) = a + b u + c u^2, u = 2 distance / length - 1. The sagitta is the height of its middle above its chord: -c.
struct Bow {
  std::vector<double> height_error;  ///< of each sample, truth's unit
  double fit[3] = {0, 0, 0};         ///< a, b, c
  double sagitta = 0;                ///< truth's unit; positive: the strip's middle is too high
  double percent = 0;                ///< of the flying height
};
/// None for fewer than fewest_poses_of_drift samples or without a flying height.
[[nodiscard]] std::optional<Bow> measure_bow(const StripTrack& track);

/// The bow that would be left, % of the flying height, if the camera were moved up or down at each sample until its
/// distance to the reconstructed ground is the measured height: what heights can do against a bow. None where fewer
/// than fewest_poses_of_drift samples have both. The truth's unit must be the metre.
[[nodiscard]] std::optional<double> bow_after_heights_percent(const StripTrack& track);

}  // namespace ilp::score
