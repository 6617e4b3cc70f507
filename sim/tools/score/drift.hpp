// Measures errors that grow along a strip: drift of position, drift of scale, and bow of the heights.
#pragma once

#include <optional>
#include <vector>

#include "sim/tools/score/pose_score.hpp"

namespace ilp::score {

/// Shorter strips have no separate beginning and end.
inline constexpr std::size_t fewest_poses_of_drift = 6;

/// Accumulated position error. The first quarter of the samples, at least `fewest_poses`, is aligned to the truth by
/// positions and attitudes (align_cameras with the flying height as reach). The errors of the later samples have
/// accumulated since.
struct Drift {
  std::size_t aligned_samples = 0;
  std::vector<Vec3> error;  ///< aligned minus true centre of each sample, truth's axes and unit
  double end_error = 0;     ///< length of the last error
  double percent = 0;       ///< end_error, % of the distance flown
};
/// Empty for fewer than fewest_poses_of_drift samples, or if the alignment is impossible.
[[nodiscard]] std::optional<Drift> measure_drift(const StripTrack& track);

/// Change of the scale along a strip. Each step between consecutive samples has a local scale: estimated length divided
/// by true length. A line is fitted to the logarithms of the local scales against the distance flown to the middle of
/// the step. The weights are the squared true lengths (all positions have the same error). Steps of length 0 are left
/// out.
struct ScaleDrift {
  std::vector<double> local_scale;  ///< around each sample (two steps each way), divided by the strip's mean scale
  double percent = 0;               ///< change of the fitted scale from begin to end; positive: growing
};
/// Empty for fewer than 5 steps.
[[nodiscard]] std::optional<ScaleDrift> measure_scale_drift(const StripTrack& track);

/// Perpendicular unit vectors in the truth's world. `forward` is the main direction of the track. `up` is opposite to
/// the mean line of sight, made perpendicular to `forward`, because the truth's world may have no vertical axis.
struct TrackAxes {
  Vec3 forward = Vec3::UnitX(), up = Vec3::UnitZ();
};
/// The track must have at least one sample.
[[nodiscard]] TrackAxes track_axes(const StripTrack& track);

/// Bow of a strip. All samples are aligned by align_cameras. The parabola h(u) = a + b u + c u^2, u = 2 distance /
/// length - 1, is fitted to the height errors along TrackAxes::up. Its sagitta, the height of its middle above its
/// chord, is -c.
struct Bow {
  std::vector<double> height_error;  ///< of each sample, truth's unit
  double fit[3] = {0, 0, 0};         ///< a, b, c
  double sagitta = 0;                ///< truth's unit; positive: the strip's middle is too high
  double percent = 0;                ///< sagitta, % of the flying height
};
/// Empty for fewer than fewest_poses_of_drift samples or without a flying height.
[[nodiscard]] std::optional<Bow> measure_bow(const StripTrack& track);

/// The bow, % of the flying height, that remains if each camera is moved vertically until its distance to the
/// reconstructed ground is the measured height. Shows how much measured heights can reduce a bow. Empty if fewer than
/// fewest_poses_of_drift samples have both a ground distance and a measured height. The truth's unit must be the metre.
[[nodiscard]] std::optional<double> bow_after_heights_percent(const StripTrack& track);

}  // namespace ilp::score
