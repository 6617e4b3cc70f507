#include "sim/ground/intake/move_keyframe.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::intake {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

Mat6 full_of(const double (&lower)[21]) {
  Mat6 full;
  for (int row = 0, i = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++i) full(row, column) = full(column, row) = lower[i];
  }
  return full;
}

void put_lower(const Mat6& full, double (&lower)[21]) {
  for (int row = 0, i = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++i) lower[i] = full(row, column);
  }
}

}  // namespace

void move(const Similarity& by, PoseRecord& pose) {
  RigidTransform turned;
  turned.rotation = rotation_from_quaternion(pose.q_cam_from_world) * by.rotation.transpose();
  const Pose attitude = pose_from(turned);
  std::copy_n(attitude.q_cam_from_world, 4, pose.q_cam_from_world);
  const Vec3 centre = by * Vec3(pose.centre[0], pose.centre[1], pose.centre[2]);
  std::copy_n(centre.data(), 3, pose.centre);
  // The rotation's error stands in the camera's axes, the centre's in the world's.
  Mat6 change = Mat6::Identity();
  change.bottomRightCorner<3, 3>() = by.scale * by.rotation;
  const Mat6 covariance = change * full_of(pose.covariance) * change.transpose();
  const bool known =
      std::any_of(std::begin(pose.covariance), std::end(pose.covariance), [](double c) { return c != 0; });
  if (known) {
    put_lower(covariance, pose.covariance);
    for (int k = 0; k < 3; ++k) pose.sigma[k] = std::sqrt(std::max(0.0, covariance(3 + k, 3 + k)));
  }
  Mat6 step = Mat6::Identity();
  step.bottomRightCorner<3, 3>() *= by.scale;
  put_lower(step * full_of(pose.step_covariance) * step.transpose(), pose.step_covariance);
  for (double* length : {&pose.min_depth, &pose.max_depth, &pose.ground_distance, &pose.ground_distance_sigma}) {
    *length *= by.scale;
  }
}

void move(const Similarity& by, StructurePoint& point) {
  double(&p)[3] = point.position;
  const Vec3 moved = by * Vec3(p[0], p[1], p[2]);
  std::copy_n(moved.data(), 3, p);
}

void move(const Similarity& by, Keyframe& keyframe) {
  if (keyframe.pose) move(by, *keyframe.pose);
  keyframe.depth_scale *= by.scale;
  if (keyframe.fix) {
    keyframe.fix->ground_depth *= by.scale;
    keyframe.fix->ground_depth_sigma *= by.scale;
  }
  for (StructureTrackPoint& track : keyframe.points) move(by, track.point);
  if (!keyframe.coded_points.empty()) keyframe.points_moved.push_back(by);
}

}  // namespace ilp::intake
