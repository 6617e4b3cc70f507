// How far the poses of a strip are from the truth.
//
// Symbols: c the estimated camera centre, R its cam_from_world, in the strip's world and unit; C, Q the true ones, in
// the truth's world and unit. "Distance" is the true path length over the strip's posed keyframes, in their order.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

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

/// Fewer poses leave a similarity (7 degrees of freedom) little to contradict.
inline constexpr std::size_t fewest_poses = 4;

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

}  // namespace ilp::score
