// Similarities in three dimensions: b_from_a maps coordinates of frame a to frame b, x_b = s R x_a + t.
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

struct Similarity {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  double scale = 1;

  Vec3 operator*(const Vec3& x) const { return scale * (rotation * x) + translation; }
};

/// A small change of a similarity, x + w * x + t + l x: rotation vector w (rad), translation t, logarithm l of the
/// scale.
using SimilarityStep = Eigen::Matrix<double, 7, 1>;
using SimilarityCovariance = Eigen::Matrix<double, 7, 7>;
inline constexpr int similarity_covariance_elements = 28;  ///< the lower triangle, row by row

[[nodiscard]] Similarity similarity_from(const RigidTransform& rigid);
/// c_from_a = compose(c_from_b, b_from_a).
[[nodiscard]] Similarity compose(const Similarity& c_from_b, const Similarity& b_from_a);
[[nodiscard]] Similarity inverse(const Similarity& b_from_a);

/// b_from_a followed by the step in frame b. The rotation and the scale are exact for steps of any size.
[[nodiscard]] Similarity stepped(const SimilarityStep& step, const Similarity& b_from_a);
/// The step that takes `from` to `to`, both b_from_a: stepped(step, from) = to.
[[nodiscard]] SimilarityStep step_between(const Similarity& from, const Similarity& to);
/// The matrix that takes a step in frame a to the same change in frame b.
[[nodiscard]] SimilarityCovariance step_in_other_frame(const Similarity& b_from_a);
/// The derivative of x + w * x + t + l x with respect to the step (w, t, l).
[[nodiscard]] Eigen::Matrix<double, 3, 7> change_by_step(const Vec3& x);

void pack_covariance(const SimilarityCovariance& covariance, double (&lower)[similarity_covariance_elements]);
[[nodiscard]] SimilarityCovariance unpack_covariance(const double (&lower)[similarity_covariance_elements]);

}  // namespace ilp
