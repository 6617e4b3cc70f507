// Scores the poses of a strip and their sigmas against the truth.
//
// Symbols: c is the estimated camera centre and R its cam_from_world, in the strip's world and unit. C and Q are the
// true ones, in the truth's world and unit. "Distance" is the true path length along the strip's posed keyframes.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "sim/ground/report/accuracy.hpp"
#include "sim/host/alignment.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::score {

/// A keyframe with a final pose and a true one.
struct PoseSample {
  std::int64_t keyframe_id = 0;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  Vec3 sigma = Vec3::Zero();  ///< of the centre by the flight, strip's axes and unit; 0: not known
  Mat3 true_cam_from_world = Mat3::Identity();
  Vec3 true_centre = Vec3::Zero();
  double ground_distance = 0;  ///< from the centre straight down to the reconstructed ground, strip unit; 0: not known
  double measured_height_m = 0;  ///< height above ground from the vehicle; 0: not measured
};

struct StripTrack {
  std::vector<PoseSample> samples;  ///< in order of flight
  bool metric = false;              ///< the scale was measured: the strip's unit is the truth's
  double flying_height = 0;         ///< truth's unit
  bool from_the_start = true;       ///< the first two samples are the strip's first two posed keyframes

  /// The estimated and the true track of the first `count` samples.
  [[nodiscard]] host::CameraTrack estimate(std::size_t count) const;
  [[nodiscard]] host::CameraTrack truth(std::size_t count) const;
};

using report::fewest_poses;

struct PoseScore {
  /// Least-squares alignment of the centres (host::track_errors).
  host::Similarity3 true_from_strip;
  std::vector<double> distance;  ///< distance up to each sample, truth's unit
  std::vector<Vec3> error;       ///< aligned minus true centre, truth's axes and unit
  host::ErrorSummary position;   ///< of the lengths of the errors
  /// The same for an alignment with scale 1; empty unless the strip is metric.
  std::optional<host::ErrorSummary> position_rigid;
  /// Angle of Q W R^T of each sample, where W is the mean attitude difference (host::align_attitudes).
  std::vector<double> rotation_rad;

  [[nodiscard]] double length() const { return distance.empty() ? 0 : distance.back(); }
};

/// Empty for fewer than fewest_poses samples, or if all estimated or all true centres coincide.
[[nodiscard]] std::optional<PoseScore> score_poses(const StripTrack& track);

/// True path length up to each sample.
[[nodiscard]] std::vector<double> distance_flown(const StripTrack& track);

// Compares position errors with the sigmas that the flight estimates.
//
// The flight's sigmas are relative to the gauge of the strip's world: the pose of the first posed camera and the length
// of the first baseline, which have no error in this world (fsw/vision/multiview/sequence_covariance.hpp). The errors
// must have the same gauge. Therefore the truth is aligned to the strip by
//   rotation  that of the first camera's attitude, W = R_0^T Q_0,
//   scale     that of the first baseline, s = |c_1 - c_0| / |C_1 - C_0|,
//   origin    the first camera.
// The error e_i = (c_i - c_0) - s W (C_i - C_0) has the strip's axes and unit, like sigma. A wrong attitude or scale of
// the first pair is in e and in sigma, although a best alignment of all samples would remove it. The errors of one
// strip are correlated, so that shares are meaningful over many strips only. The first two samples, which define the
// gauge, and samples with a sigma of 0 are left out.

/// Transforms the truth's world to the strip's world as above. Empty if the track does not begin with the strip's first
/// two posed keyframes (StripTrack::from_the_start), or if their true centres coincide.
[[nodiscard]] std::optional<host::Similarity3> strip_from_true(const StripTrack& track);

/// Statistics of errors divided by their sigmas. Normal errors with correct sigmas give shares of 68.3 % within one
/// and 95.4 % within two sigmas, and a normalised error squared of 1. A larger normalised error squared means that the
/// flight's sigmas are too small.
struct SigmaScore {
  std::size_t components = 0;  ///< number of compared components; poses have three per sample
  std::size_t within_one = 0, within_two = 0;
  double squared_sum = 0;              ///< sum of (error / sigma)^2
  std::map<std::int64_t, Vec3> error;  ///< e by keyframe id, strip's axes and unit

  void add(const SigmaScore& other);
  /// Counts a component with this error / sigma. Does not change squared_sum.
  void count(double normalised);
  /// NaN if nothing was compared.
  [[nodiscard]] double share_within_one() const;
  [[nodiscard]] double share_within_two() const;
  [[nodiscard]] double normalised_error_squared() const;
};

/// Compares nothing if strip_from_true is empty.
[[nodiscard]] SigmaScore score_sigmas(const StripTrack& track);

}  // namespace ilp::score
