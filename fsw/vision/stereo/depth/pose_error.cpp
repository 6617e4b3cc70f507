#include "fsw/vision/stereo/depth/pose_error.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

Mat6 full_of(const StepCovariance& covariance) {
  Mat6 full;
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) full(row, column) = full(column, row) = covariance.lower[k];
  }
  return full;
}

}  // namespace

StepCovariance joined_steps(const RigidTransform& b_from_a, const StepCovariance& first, const RigidTransform& c_from_b,
                            const StepCovariance& second) {
  if (!first.known() || !second.known()) return {};
  const Vec3 c_in_b = inverse(c_from_b).translation;
  Mat6 of_first = Mat6::Identity();
  of_first.topLeftCorner<3, 3>() = c_from_b.rotation;
  of_first.bottomLeftCorner<3, 3>() = b_from_a.rotation.transpose() * cross_matrix(c_in_b);
  Mat6 of_second = Mat6::Identity();
  of_second.bottomRightCorner<3, 3>() = b_from_a.rotation.transpose();
  const Mat6 joined =
      of_first * full_of(first) * of_first.transpose() + of_second * full_of(second) * of_second.transpose();
  StepCovariance result;
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) result.lower[k] = joined(row, column);
  }
  return result;
}

double depth_error_of_poses(const RigidTransform& second_from_first, const StepCovariance& covariance,
                            const Vec2& normalised, double depth) {
  if (!covariance.known() || !(depth > 0)) return 0;
  const Vec3 ray = second_from_first.rotation * Vec3(normalised.x(), normalised.y(), 1);
  const Vec3 q = depth * ray + second_from_first.translation;
  if (!(q.z() > 1e-9 * depth)) return 0;
  // Derivative of the image point in the second image by its place in that camera.
  Eigen::Matrix<double, 2, 3> projection;
  projection << 1 / q.z(), 0, -q.x() / (q.z() * q.z()), 0, 1 / q.z(), -q.y() / (q.z() * q.z());
  const Vec2 along = projection * ray;
  const double squared = along.squaredNorm();
  if (!(squared > 0)) return 0;
  // Derivative of the place q by the error of the step: rotation x q, and the camera's own move with opposite sign.
  Eigen::Matrix<double, 3, 6> moved;
  moved.leftCols<3>() = -cross_matrix(q);
  moved.rightCols<3>() = -second_from_first.rotation;
  const Eigen::Matrix<double, 1, 6> shift = along.transpose() * projection * moved / squared;
  double variance = 0;
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) {
      variance += (row == column ? 1 : 2) * shift[row] * shift[column] * covariance.lower[k];
    }
  }
  return variance > 0 ? std::sqrt(variance) / depth : 0;
}

double median_depth_error_of_poses(const RigidTransform& second_from_first, const StepCovariance& covariance,
                                   const CameraModel& camera, ImageView<const float> inverse_depth,
                                   PoseErrorScratch& scratch) {
  if (!covariance.known()) return 0;
  std::size_t count = 0;
  for (std::int32_t y = pose_error_stride_px / 2; y < camera.height; y += pose_error_stride_px) {
    for (std::int32_t x = pose_error_stride_px / 2; x < camera.width; x += pose_error_stride_px) {
      const double inverse = static_cast<double>(inverse_depth.at(x, y));
      if (!(inverse > 0)) continue;
      const Vec2 direction = normalised_from_pixel(camera, Vec2(x, y));
      scratch.values[count++] = depth_error_of_poses(second_from_first, covariance, direction, 1 / inverse);
    }
  }
  if (count == 0) return 0;
  double* const middle = scratch.values + count / 2;
  std::nth_element(scratch.values, middle, scratch.values + count);
  return *middle;
}

}  // namespace ilp
