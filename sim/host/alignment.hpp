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

/// Least-squares similarity of all positions. Empty for fewer than two positions, or if all coincide. On a straight
/// track the rotation about the track is arbitrary, because it moves no position.
[[nodiscard]] std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates,
                                                         const std::vector<Vec3>& references);

/// Fits scale and translation only, for a given rotation, so that a wrong attitude of the whole track remains as an
/// error.
[[nodiscard]] std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates,
                                                         const std::vector<Vec3>& references, const Mat3& rotation);

/// Fits rotation and translation, with scale 1, for a track whose scale is known. Empty as above.
[[nodiscard]] std::optional<Similarity3> align_rigid(const std::vector<Vec3>& estimates,
                                                     const std::vector<Vec3>& references);

/// Aligns positions and attitudes together, so that the rotation about a straight track is determined as well. The
/// rotation is the least-squares one of the centred positions and of the axes of every camera, drawn `reach` long (in
/// the reference's unit, usually the flying height). Scale and translation are then fitted to the positions. Empty as
/// above.
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

/// Errors of each camera of a track. The alignment has 7 degrees of freedom, so that the errors of fewer than four
/// cameras say little.
struct TrackErrors {
  Similarity3 reference_from_track;  ///< from the positions (align_positions)
  Mat3 reference_axes_from_track;    ///< from the attitudes (align_attitudes)
  std::vector<Vec3> position;        ///< aligned minus reference centre
  std::vector<double> rotation_rad;  ///< remaining angle after the attitudes were aligned
};

/// Empty where align_positions is empty. Both tracks have the same cameras in the same order.
[[nodiscard]] std::optional<TrackErrors> track_errors(const CameraTrack& track, const CameraTrack& reference);

/// Aligned minus reference centre of each camera, in the reference's axes and unit.
[[nodiscard]] std::vector<Vec3> position_errors(const Similarity3& reference_from_track, const CameraTrack& track,
                                                const CameraTrack& reference);

}  // namespace ilp::host
