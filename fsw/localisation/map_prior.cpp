#include "fsw/localisation/map_prior.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr double drift_share = 0.01;        // of the way since the newest fix
constexpr double least_sigma_rad = 0.0017;  // of an attitude: 0.1 degrees, for what the poses err among themselves
constexpr double relief_share = 0.02;       // of the height: the ground below the camera is not that of the map's posts

double square(double x) {
  return x * x;
}

void set_pose(const Mat3& cam_from_map, const Vec3& centre, MapPrior& prior) {
  prior.camera_from_map.rotation = cam_from_map;
  prior.camera_from_map.translation = -(cam_from_map * centre);
}

void set_attitude_sigma(double tilt_rad, double heading_rad, MapPrior& prior) {
  const double floor2 = square(least_sigma_rad);
  const Mat3& cam = prior.camera_from_map.rotation;
  const Mat3 level =
      Vec3(square(tilt_rad) + floor2, square(tilt_rad) + floor2, square(heading_rad) + floor2).asDiagonal();
  prior.covariance.topLeftCorner<3, 3>() = cam * level * cam.transpose();
}

}  // namespace

PoseCovariance covariance_over_ground(const Mat3& cam_from_map, double distance_m, const Mat3& attitude,
                                      const Vec3& variances_m2) {
  // centre = ground - distance * axis, and a turn w of the camera takes the axis z to z - w x z.
  PoseCovariance by = PoseCovariance::Identity();
  by.bottomLeftCorner<3, 3>() = -distance_m * (cam_from_map.transpose() * cross_matrix(Vec3(0, 0, 1)));
  PoseCovariance own = PoseCovariance::Zero();
  own.topLeftCorner<3, 3>() = attitude;
  own.bottomRightCorner<3, 3>() = variances_m2.asDiagonal();
  return by.lazyProduct(own).lazyProduct(by.transpose());
}

bool prior_by_fixes(const navigation::StripFrame& frame, const PoseRecord& pose, double way_m, MapPrior& prior) {
  const bool known = frame.fixed_sigma_m[0] > 0 && frame.fixed_sigma_m[1] > 0 && frame.scale_sigma > 0 &&
                     frame.tilt_sigma_rad > 0 && frame.heading_sigma_rad > 0;
  if (!known) return false;
  const Vec3 centre = vector_of(pose.centre);
  const Mat3 cam_from_strip = rotation_from_quaternion(pose.q_cam_from_world);
  const navigation::FixedPlace at = navigation::place_by_fixes(frame, centre);
  prior = {};
  set_pose(cam_from_strip * frame.level_from_strip.transpose(), at.place_m, prior);
  set_attitude_sigma(frame.tilt_sigma_rad, frame.heading_sigma_rad, prior);
  // The ground below is known better than the camera.
  const double distance_m = std::max(at.place_m.z() - frame.fixed_place_m.z(), 0.0);
  const Vec3 axis = cam_from_strip.row(2);
  const navigation::FixedPlace below =
      navigation::place_by_fixes(frame, centre + distance_m / frame.metres_per_unit * axis);
  const double drift = square(drift_share * way_m);
  const Vec3 variances(square(below.sigma_m[0]) + drift, square(below.sigma_m[1]) + drift,
                       square(at.sigma_m[2]) + drift);
  const Mat3 attitude = prior.covariance.topLeftCorner<3, 3>();
  prior.covariance = covariance_over_ground(prior.camera_from_map.rotation, distance_m, attitude, variances);
  return prior.covariance.allFinite() && prior.camera_from_map.translation.allFinite();
}

bool place_by_vehicle(const navigation::StripFrame& frame, const navigation::MeasuredKeyframe& keyframe, Vec3& place_m,
                      double& sigma_m) {
  if (keyframe.horizontal_sigma_m > 0) {
    place_m = vector_of(keyframe.place_m);
    sigma_m = keyframe.horizontal_sigma_m;
    return true;
  }
  if (!(frame.horizontal_sigma_m > 0)) return false;
  const Vec3 way = frame.metres_per_unit * (frame.level_from_strip * vector_of(keyframe.centre));
  place_m = frame.origin_m + way;
  const double turned = square(frame.heading_sigma_rad) + square(frame.scale_sigma) + square(drift_share);
  sigma_m = std::sqrt(square(frame.horizontal_sigma_m) + turned * way.squaredNorm());
  return true;
}

bool prior_by_vehicle(const navigation::StripFrame& frame, const navigation::MeasuredKeyframe& keyframe,
                      double ground_m, MapPrior& prior) {
  prior = {};
  Vec3 place = Vec3::Zero();
  double place_sigma = 0;
  if (!place_by_vehicle(frame, keyframe, place, place_sigma)) return false;

  double height_sigma = 0;
  if (keyframe.height_sigma_m > 0) {
    height_sigma = std::sqrt(square(keyframe.height_sigma_m) + square(relief_share * keyframe.height_m));
    place.z() = ground_m + keyframe.height_m;
  } else if (frame.scale_sigma > 0 && keyframe.ground_distance > 0) {
    const double height = frame.metres_per_unit * keyframe.ground_distance;
    height_sigma = height * std::sqrt(square(frame.scale_sigma) + square(relief_share));
    place.z() = ground_m + height;
  } else if (keyframe.vertical_sigma_m > 0) {
    height_sigma = keyframe.vertical_sigma_m;
  } else {
    return false;
  }

  const bool measured = keyframe.tilt_sigma_rad > 0 && keyframe.heading_sigma_rad > 0;
  const bool by_frame = frame.tilt_sigma_rad > 0 && frame.heading_sigma_rad > 0;
  if (!measured && !by_frame) return false;
  const Mat3 cam_from_map =
      measured ? rotation_from_quaternion(keyframe.q_cam_from_level)
               : Mat3(rotation_from_quaternion(keyframe.q_cam_from_strip) * frame.level_from_strip.transpose());
  set_pose(cam_from_map, place, prior);
  set_attitude_sigma(measured ? keyframe.tilt_sigma_rad : frame.tilt_sigma_rad,
                     measured ? keyframe.heading_sigma_rad : frame.heading_sigma_rad, prior);
  prior.attitude_is_measured = measured;
  for (int axis = 0; axis < 2; ++axis) prior.covariance(3 + axis, 3 + axis) = square(place_sigma);
  prior.covariance(5, 5) = square(height_sigma);
  return prior.covariance.allFinite() && prior.camera_from_map.translation.allFinite();
}

}  // namespace ilp
