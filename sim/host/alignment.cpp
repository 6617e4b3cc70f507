#include "sim/host/alignment.hpp"

#include <Eigen/SVD>

namespace ilp::ground {
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

}  // namespace

std::optional<Similarity3> align_positions(const std::vector<Vec3>& estimates, const std::vector<Vec3>& references) {
  const Moments m = moments(estimates, references);
  if (!usable(m, estimates.size())) return std::nullopt;
  Similarity3 s;
  Vec3 singular;
  double handedness = 1;
  s.rotation = nearest_rotation(m.covariance, singular, handedness);
  s.scale = (singular[0] + singular[1] + handedness * singular[2]) / m.variance_from;
  s.translation = m.mean_to - s.scale * (s.rotation * m.mean_from);
  return s;
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
  const Moments m = moments(estimates, references);
  if (!usable(m, estimates.size())) return std::nullopt;
  Similarity3 s;
  Vec3 singular;
  double handedness = 1;
  s.rotation = nearest_rotation(m.covariance, singular, handedness);
  s.translation = m.mean_to - s.rotation * m.mean_from;
  return s;
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

}  // namespace ilp::ground
