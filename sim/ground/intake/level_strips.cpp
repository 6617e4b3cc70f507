#include "sim/ground/intake/level_strips.hpp"

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

/// Length and direction of a strip's world in the level frame.
struct Similarity {
  double scale = 1;
  Mat3 turn = Mat3::Identity();
};

bool plausible(const StripFrameRecord& frame) {
  double norm2 = 0;
  for (const double q : frame.q_level_from_strip) norm2 += q * q;
  return std::fabs(norm2 - 1) < 1e-3 && frame.metres_per_unit > 1e-6 && frame.metres_per_unit < 1e6 &&
         std::isfinite(frame.scale_sigma);
}

void apply(const Similarity& by, PoseRecord& pose) {
  RigidTransform turned;
  turned.rotation = rotation_from_quaternion(pose.q_cam_from_world) * by.turn.transpose();
  const Pose attitude = pose_from(turned);
  std::copy_n(attitude.q_cam_from_world, 4, pose.q_cam_from_world);
  const Vec3 centre = by.scale * (by.turn * Vec3(pose.centre[0], pose.centre[1], pose.centre[2]));
  std::copy_n(centre.data(), 3, pose.centre);
  // The rotation's error stands in the camera's axes, the centre's in the world's.
  Mat6 change = Mat6::Identity();
  change.bottomRightCorner<3, 3>() = by.scale * by.turn;
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

void apply(const Similarity& by, Keyframe& keyframe) {
  if (keyframe.pose) apply(by, *keyframe.pose);
  keyframe.metres_per_unit = by.scale;
  for (StructureTrackPoint& track : keyframe.points) {
    double(&p)[3] = track.point.position;
    const Vec3 point = by.scale * (by.turn * Vec3(p[0], p[1], p[2]));
    std::copy_n(point.data(), 3, p);
  }
}

}  // namespace

void level_strips(Flight& flight) {
  for (auto& [id, strip] : flight.strips) {
    if (!strip.frame) continue;
    if (!plausible(*strip.frame)) {
      flight.remarks.push_back("strip " + std::to_string(id) + ": its place by the vehicle's navigation is none");
      strip.frame.reset();
      continue;
    }
    const bool metric = strip.frame->scale_sigma > 0;
    Similarity by;
    if (metric) by.scale = strip.frame->metres_per_unit;
    by.turn = rotation_from_quaternion(strip.frame->q_level_from_strip);
    for (const std::int64_t keyframe_id : strip.keyframes) {
      Keyframe& keyframe = flight.keyframes.at(keyframe_id);
      apply(by, keyframe);
      if (metric && keyframe.pose) keyframe.pose->scale_source = ScaleSource::navigation;
    }
  }
}

}  // namespace ilp::intake
