// Aligns two point sets by a similarity (S. Umeyama, "Least-squares estimation of transformation parameters between two
// point patterns", PAMI 1991), to compare reconstructions whose frame and scale are arbitrary.
#pragma once

#include <Eigen/Core>
#include <Eigen/SVD>
#include <cmath>
#include <vector>

namespace ilp::test {

struct Alignment {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return scale * (rotation * x) + translation; }
};

/// Returns the similarity that minimises the sum of the squared distances between alignment * source[i] and target[i].
inline Alignment align(const std::vector<Eigen::Vector3d>& source, const std::vector<Eigen::Vector3d>& target) {
  Alignment result;
  const auto n = static_cast<double>(source.size());
  Eigen::Vector3d mean_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_t = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    mean_s += source[i] / n;
    mean_t += target[i] / n;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += (target[i] - mean_t) * (source[i] - mean_s).transpose() / n;
    variance += (source[i] - mean_s).squaredNorm() / n;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  result.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  result.scale = svd.singularValues().dot(sign) / variance;
  result.translation = mean_t - result.scale * (result.rotation * mean_s);
  return result;
}

struct AlignmentErrors {
  double mean = 0;
  double worst = 0;
};

/// Mean and maximum distance between corresponding points after the alignment, in units of the target.
inline AlignmentErrors alignment_errors(const std::vector<Eigen::Vector3d>& source,
                                        const std::vector<Eigen::Vector3d>& target) {
  const Alignment target_from_source = align(source, target);
  AlignmentErrors errors;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const double error = (target_from_source * source[i] - target[i]).norm();
    errors.mean += error / static_cast<double>(source.size());
    errors.worst = error > errors.worst ? error : errors.worst;
  }
  return errors;
}

}  // namespace ilp::test
