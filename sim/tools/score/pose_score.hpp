// How far the poses of a strip are from the truth.
//
// Symbols: c the estimated camera centre, R its cam_from_world, in the strip's world and unit; C, Q the true ones, in
// the truth's world and unit. "Distance" is the true path length over the strip's posed keyframes, in their order.
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
  Vec3 sigma = Vec3::Zero();  ///< as stated, along the strip's axes; 0 where none is stated
  Mat3 true_cam_from_world = Mat3::Identity();
  Vec3 true_centre = Vec3::Zero();
  double ground_distance = 0;    ///< straight down to the reconstructed ground, strip unit; 0: not known
  double measured_height_m = 0;  ///< the vehicle's; 0: not measured
};

struct StripTrack {
  std::vector<PoseSample> samples;  ///< in order of flight
  bool metric = false;              ///< an altimeter fixed the scale: the strip's unit is the truth's
  double flying_height = 0;         ///< truth's unit
  bool from_the_start = true;       ///< the first samples are the strip's first posed keyframes: the truth knows them

  /// The tracks of the first `count` samples.
  [[nodiscard]] host::CameraTrack estimate(std::size_t count) const;
  [[nodiscard]] host::CameraTrack truth(std::size_t count) const;
};

using report::fewest_poses;

struct PoseScore {
  /// Least squares over the centres (host::track_errors).
  host::Similarity3 true_from_strip;
  std::vector<double> distance;  ///< flown up to each sample, truth's unit
  std::vector<Vec3> error;       ///< aligned minus true centre, truth's axes and unit
  host::ErrorSummary position;   ///< of their lengths
  /// The same without scale alignment; only of metric strips.
  std::optional<host::ErrorSummary> position_rigid;
  /// Angle of Q W R^T per sample, W the mean attitude difference (align_attitudes).
  std::vector<double> rotation_rad;

  [[nodiscard]] double length() const { return distance.empty() ? 0 : distance.back(); }
};

/// None for fewer than fewest_poses samples, or where all centres (estimated or true) coincide.
[[nodiscard]] std::optional<PoseScore> score_poses(const StripTrack& track);

/// True path length up to each sample.
[[nodiscard]] std::vector<double> distance_flown(const StripTrack& track);

// Whether the estimated position sigmas are honest.
//
// The flight states a keyframe's sigma relative to the gauge of its strip's world: the pose of the strip's first posed
// camera and the length of the first baseline, which define this world and so are without error in it
// (fsw/vision/multiview/sequence_covariance.hpp). The error that is compared is relative to the same: the truth is laid
// onto the strip by
//   rotation  that of the first camera's attitude, W = R_0^T Q_0,
//   scale     of the first baseline, s = |c_1 - c_0| / |C_1 - C_0|,
//   origin    the first camera;
// the error is then e_i = (c_i - c_0) - s W (C_i - C_0), along the strip's axes and in its unit, like sigma. What the
// best alignment of the whole strip would take away, a wrong attitude or scale of the first pair, is in e and in sigma
// alike. The errors of one strip are correlated, so shares are worth something over many strips only.
// The first two samples define the gauge, and sigmas of 0 state nothing: both are left out.

/// Takes the truth's world to the strip's as above. None if the track does not begin with the first two posed keyframes
/// of the strip (StripTrack::from_the_start), or these have one place.
[[nodiscard]] std::optional<host::Similarity3> strip_from_true(const StripTrack& track);

/// With normal errors and exact sigmas 68.3 % are within one and 95.4 % within two, and the normalised error squared is
/// 1; if it is larger, the flight states its errors too small.
struct SigmaScore {
  std::size_t components = 0;  ///< of poses: three per sample
  std::size_t within_one = 0, within_two = 0;
  double squared_sum = 0;              ///< of error / sigma
  std::map<std::int64_t, Vec3> error;  ///< e by keyframe, strip axes and unit

  void add(const SigmaScore& other);
  /// The error of one component in units of its sigma; not added to squared_sum.
  void count(double normalised);
  /// NaN where nothing was compared.
  [[nodiscard]] double share_within_one() const;
  [[nodiscard]] double share_within_two() const;
  [[nodiscard]] double normalised_error_squared() const;
};

/// Nothing is compared where strip_from_true has none.
[[nodiscard]] SigmaScore score_sigmas(const StripTrack& track);

}  // namespace ilp::score
