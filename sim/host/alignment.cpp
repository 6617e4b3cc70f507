#include "sim/host/alignment.hpp"

#include <Eigen/SVD>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::host {
namespace {

struct Moments {
  Vec3 mean_from = Vec3::Zero(), mean_to = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  double variance_from = 0;
};

Moments moments(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  Moments m;
  const auto n = static_cast<double>(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    m.mean_from += from[i] / n;
    m.mean_to += to[i] / n;
  }
  for (std::size_t i = 0; i < from.size(); ++i) {
    m.covariance += (to[i] - m.mean_to) * (from[i] - m.mean_from).transpose() / n;
    m.variance_from += (from[i] - m.mean_from).squaredNorm() / n;
  }
  return m;
}

Mat3 nearest_rotation(const Mat3& matrix, Vec3& singular, double& handedness) {
  const Eigen::JacobiSVD<Mat3> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  singular = svd.singularValues();
  handedness = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
  const Vec3 signs(1, 1, handedness);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

bool usable(const Moments& m, std::size_t count) {
  return count >= 2 && m.variance_from > 0 && m.covariance.squaredNorm() > 0;
}

std::optional<Similarity3> align(const std::vector<Vec3>& estimates, const std::vector<Vec3>& references,
                                 bool with_scale) {
  const Moments m = moments(estimates, references);
  if (!usable(m, estimates.size())) return std::nullopt;
  Similarity3 s;
  Vec3 singular;
  double handedness = 1;
  s.rotation = nearest_rotation(m.covariance, singular, handedness);
  if (with_scale) s.scale = (singular[0] + singular[1] + handedness * singular[2]) / m.variance_from;
  s.translation = m.mean_to - s.scale * (s.rotation * m.mean_from);
  return s;
}

}  // namespace

std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates, const std::vector<Vec3>& references) {
  return align(estimates, references, true);
}

std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates, const std::vector<Vec3>& references,
                                           const Mat3& rotation) {
  const Moments m = moments(estimates, references);
  if (!usable(m, estimates.size())) return std::nullopt;
  Similarity3 s;
  s.rotation = rotation;
  s.scale = (rotation.transpose() * m.covariance).trace() / m.variance_from;
  s.translation = m.mean_to - s.scale * (rotation * m.mean_from);
  return s;
}

std::optional<Similarity3> align_rigid(const std::vector<Vec3>& estimates, const std::vector<Vec3>& references) {
  return align(estimates, references, false);
}

std::optional<Similarity3> align_cameras(const std::vector<Vec3>& estimates, const std::vector<Mat3>& cam_from_estimate,
                                         const std::vector<Vec3>& references,
                                         const std::vector<Mat3>& cam_from_reference, double reach) {
  const auto by_positions = align_positions(estimates, references);
  if (!by_positions) return std::nullopt;
  const auto n = static_cast<double>(estimates.size());
  Mat3 agreement = by_positions->scale * moments(estimates, references).covariance;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    agreement += (reach * reach / n) * (cam_from_reference[i].transpose() * cam_from_estimate[i]);
  }
  Vec3 singular;
  double handedness = 1;
  return align_positions(estimates, references, nearest_rotation(agreement, singular, handedness));
}

Mat3 align_attitudes(const std::vector<Mat3>& cam_from_estimate, const std::vector<Mat3>& cam_from_reference) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < cam_from_estimate.size(); ++i) {
    sum += cam_from_reference[i].transpose() * cam_from_estimate[i];
  }
  Vec3 singular;
  double handedness = 1;
  return nearest_rotation(sum, singular, handedness);
}

std::vector<Vec3> position_errors(const Similarity3& reference_from_track, const CameraTrack& track,
                                  const CameraTrack& reference) {
  std::vector<Vec3> errors;
  for (std::size_t i = 0; i < track.centres.size(); ++i) {
    errors.push_back(reference_from_track * track.centres[i] - reference.centres[i]);
  }
  return errors;
}

std::optional<TrackErrors> track_errors(const CameraTrack& track, const CameraTrack& reference) {
  const auto similarity = align_positions(track.centres, reference.centres);
  if (!similarity) return std::nullopt;
  // cam_from_reference * W = cam_from_track, so W takes the track's axes to those of the reference.
  TrackErrors errors{*similarity,
                     align_attitudes(track.cam_from_world, reference.cam_from_world),
                     position_errors(*similarity, track, reference),
                     {}};
  for (std::size_t i = 0; i < track.centres.size(); ++i) {
    errors.rotation_rad.push_back(rotation_angle(reference.cam_from_world[i] * errors.reference_axes_from_track *
                                                 track.cam_from_world[i].transpose()));
  }
  return errors;
}

}  // namespace ilp::host
