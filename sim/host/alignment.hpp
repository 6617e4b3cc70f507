// Similarity alignment of reconstructed positions to reference positions (S. Umeyama, "Least-squares estimation of
// transformation parameters between two point patterns", PAMI 13(4), 1991).
#pragma once

#include <optional>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::host {

/// reference = scale * rotation * estimate + translation.
struct Similarity3 {
  double scale = 1;
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator*(const Vec3& x) const { return scale * (rotation * x) + translation; }
};

/// Least squares over all positions; none for fewer than two positions or coincident ones. On a straight track the turn
/// about the track is arbitrary: it moves no position.
[[nodiscard]] std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates,
                                                         const std::vector<Vec3>& references);

/// The rotation given, only scale and translation fitted: does not forgive a wrong attitude of the whole track.
[[nodiscard]] std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates,
                                                         const std::vector<Vec3>& references, const Mat3& rotation);

/// Scale 1: for a track whose scale is known. None for fewer than two positions or coincident ones.
[[nodiscard]] std::optional<Similarity3> align_rigid(const std::vector<Vec3>& estimates,
                                                     const std::vector<Vec3>& references);

/// Positions and attitudes together, so that the turn about a straight track is determined too: the rotation is the
/// least-squares one of the centred positions and of every camera's axes drawn `reach` long (reference units: the
/// flying height, say); scale and translation are those of the positions under that rotation.
[[nodiscard]] std::optional<Similarity3> align_cameras(const std::vector<Vec3>& estimates,
                                                       const std::vector<Mat3>& cam_from_estimate,
                                                       const std::vector<Vec3>& references,
                                                       const std::vector<Mat3>& cam_from_reference, double reach);

/// The rotation W that makes cam_from_reference[i] * W nearest to cam_from_estimate[i] (chordal mean).
[[nodiscard]] Mat3 align_attitudes(const std::vector<Mat3>& cam_from_estimate,
                                   const std::vector<Mat3>& cam_from_reference);

/// Cameras in order of flight, in one world.
struct CameraTrack {
  std::vector<Vec3> centres;
  std::vector<Mat3> cam_from_world;

  void add(const Vec3& centre, const Mat3& attitude) {
    centres.push_back(centre);
    cam_from_world.push_back(attitude);
  }
};

/// How far a track is from its reference, camera by camera. The alignment has 7 degrees of freedom: with fewer than
/// four cameras the errors say little.
struct TrackErrors {
  Similarity3 reference_from_track;  ///< by the positions (align_positions)
  Mat3 reference_axes_from_track;    ///< by the attitudes (align_attitudes)
  std::vector<Vec3> position;        ///< aligned minus reference centre
  std::vector<double> rotation_rad;  ///< that is left after the attitudes were aligned
};

/// None where align_positions has none.
[[nodiscard]] std::optional<TrackErrors> track_errors(const CameraTrack& track, const CameraTrack& reference);

/// Aligned minus reference centres.
[[nodiscard]] std::vector<Vec3> position_errors(const Similarity3& reference_from_track, const CameraTrack& track,
                                                const CameraTrack& reference);

}  // namespace ilp::host
