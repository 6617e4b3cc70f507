#include "fsw/vision/geometry/similarity.hpp"

#include "fsw/base/math.hpp"

namespace ilp {

Similarity similarity_from(const RigidTransform& rigid) {
  return {rigid.rotation, rigid.translation, 1};
}

Similarity compose(const Similarity& c_from_b, const Similarity& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation, c_from_b * b_from_a.translation, c_from_b.scale * b_from_a.scale};
}

Similarity inverse(const Similarity& b_from_a) {
  const Mat3 back = b_from_a.rotation.transpose();
  return {back, -(back * b_from_a.translation) / b_from_a.scale, 1 / b_from_a.scale};
}

Similarity stepped(const SimilarityStep& step, const Similarity& b_from_a) {
  const Similarity change{rotation_from_vector(step.head<3>()), step.segment<3>(3), det_exp(step(6))};
  return compose(change, b_from_a);
}

SimilarityStep step_between(const Similarity& from, const Similarity& to) {
  const Similarity change = compose(to, inverse(from));
  SimilarityStep step;
  step.head<3>() = vector_from_rotation(change.rotation);
  step.segment<3>(3) = change.translation;
  step(6) = det_log(change.scale);
  return step;
}

Eigen::Matrix<double, 3, 7> change_by_step(const Vec3& x) {
  Eigen::Matrix<double, 3, 7> change;
  change.block<3, 3>(0, 0) = -cross_matrix(x);
  change.block<3, 3>(0, 3) = Mat3::Identity();
  change.block<3, 1>(0, 6) = x;
  return change;
}

SimilarityCovariance step_in_other_frame(const Similarity& b_from_a) {
  // With x_b = s R x_a + t, the step x_a + w * x_a + u + l x_a becomes
  // x_b + (R w) * x_b + (s R u - (R w) * t - l t) + l x_b.
  SimilarityCovariance map = SimilarityCovariance::Zero();
  map.block<3, 3>(0, 0) = b_from_a.rotation;
  map.block<3, 3>(3, 3) = b_from_a.scale * b_from_a.rotation;
  map.block<3, 3>(3, 0) = cross_matrix(b_from_a.translation) * b_from_a.rotation;
  map.block<3, 1>(3, 6) = -b_from_a.translation;
  map(6, 6) = 1;
  return map;
}

void pack_covariance(const SimilarityCovariance& covariance, double (&lower)[similarity_covariance_elements]) {
  int element = 0;
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column <= row; ++column) lower[element++] = covariance(row, column);
  }
}

SimilarityCovariance unpack_covariance(const double (&lower)[similarity_covariance_elements]) {
  SimilarityCovariance covariance;
  int element = 0;
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column <= row; ++column) {
      covariance(row, column) = covariance(column, row) = lower[element++];
    }
  }
  return covariance;
}

}  // namespace ilp
