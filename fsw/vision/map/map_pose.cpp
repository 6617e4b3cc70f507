#include "fsw/vision/map/map_pose.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/median.hpp"
#include "fsw/vision/image/small_solver.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

constexpr int most_steps = 12;
constexpr double huber = 2, left_out = 5;  // sigmas
constexpr double sigma_of_median = 1.4826;
constexpr double smallest_pivot = 1e-9;
constexpr double widest_attitude_rad = 0.5;  // one sigma: beyond it the sightings determine no pose
constexpr std::int32_t least_used = 6;

/// Median of the sizes of all residual coordinates, each in its own sigmas.
double median_size(std::span<const MapSighting> sightings, double sigma_px) {
  std::array<double, 2 * max_map_patches> sizes{};
  std::size_t count = 0;
  for (const MapSighting& sighting : sightings) {
    if (count + 2 > sizes.size()) break;
    sizes[count++] = std::fabs(sighting.residual.x()) / sigma_px;
    sizes[count++] = std::fabs(sighting.residual.y()) / sigma_px;
  }
  if (count == 0) return 0;
  return upper_median(std::span(sizes).first(count));
}

/// Working px per unit of a sighting's coordinates.
double px_per_unit(const RigidTransform& camera_from_map, const Vec3& place, double pixel_m) {
  return (camera_from_map * place).z() / pixel_m;
}

Vec6 attitude_gradient(const RigidTransform& pose, const MapPrior& prior, const Mat3& information) {
  Vec6 gradient = Vec6::Zero();
  gradient.head<3>() = information * vector_from_rotation(pose.rotation * prior.camera_from_map.rotation.transpose());
  return gradient;
}

PoseCovariance with_attitude(const PoseCovariance& normal, const Mat3& information) {
  PoseCovariance sum = normal;
  sum.topLeftCorner<3, 3>() += information;
  return sum;
}

/// With unknowns in metres at the ground, so that the pivots are comparable.
bool invert_information(const PoseCovariance& information, double distance, PoseCovariance& covariance) {
  Vec6 scale;
  scale << 1, 1, 1, distance, distance, distance;
  const PoseCovariance scaled = scale.asDiagonal() * information * scale.asDiagonal();
  PoseCovariance inverted;
  if (!invert_positive_definite<6>(scaled, inverted)) return false;
  covariance = scale.asDiagonal() * inverted * scale.asDiagonal();
  return true;
}

void measure(std::span<MapSighting> sightings, const RigidTransform& pose, double pixel_m) {
  Eigen::Matrix<double, 2, 6> by;
  for (MapSighting& sighting : sightings) {
    Vec2 residual;
    if (!sighting_residual(pose, sighting, residual, by)) {
      sighting.residual = Vec2(1e6, 1e6);
      continue;
    }
    sighting.residual = px_per_unit(pose, sighting.place, pixel_m) * residual;
  }
}

}  // namespace

template <int N>
bool invert_positive_definite(const Eigen::Matrix<double, N, N>& matrix, Eigen::Matrix<double, N, N>& inverted) {
  double factor[N][N];
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < N; ++k) factor[i][k] = matrix(i, k);
  }
  if (!factor_positive_definite(factor, smallest_pivot)) return false;
  for (int k = 0; k < N; ++k) {
    double column[N] = {};
    column[k] = 1;
    solve_factored(factor, column);
    for (int i = 0; i < N; ++i) inverted(i, k) = column[i];
  }
  return inverted.allFinite();
}
template bool invert_positive_definite(const Mat3& matrix, Mat3& inverted);
template bool invert_positive_definite(const PoseCovariance& matrix, PoseCovariance& inverted);

bool sighting_residual(const RigidTransform& camera_from_map, const MapSighting& sighting, Vec2& residual,
                       Eigen::Matrix<double, 2, 6>& by_pose) {
  const Vec3 p = camera_from_map * sighting.place;
  if (!(p.z() > 0)) return false;
  const double inverse_depth = 1 / p.z(), x = p.x() * inverse_depth, y = p.y() * inverse_depth;
  residual = Vec2(x, y) - sighting.at;
  // p' = exp([w]x) R (X - c - dc): dp = -[p]x w - R dc.
  Eigen::Matrix<double, 2, 3> by_place;
  by_place << inverse_depth, 0, -x * inverse_depth, 0, inverse_depth, -y * inverse_depth;
  by_pose.leftCols<3>() = -(by_place * cross_matrix(p));
  by_pose.rightCols<3>() = -(by_place * camera_from_map.rotation);
  return true;
}

RigidTransform changed_pose(const RigidTransform& camera_from_map, const Vec6& change) {
  RigidTransform pose;
  pose.rotation = rotation_from_vector(change.head<3>()) * camera_from_map.rotation;
  pose.translation = -(pose.rotation * (camera_centre(camera_from_map) + change.tail<3>()));
  return pose;
}

Vec6 pose_change(const RigidTransform& from, const RigidTransform& to) {
  Vec6 change;
  change.head<3>() = vector_from_rotation(to.rotation * from.rotation.transpose());
  change.tail<3>() = camera_centre(to) - camera_centre(from);
  return change;
}

bool solve_map_pose(std::span<MapSighting> sightings, const MapPrior& prior, const MapPoseParams& params,
                    MapPose& pose) {
  Mat3 information = Mat3::Zero();
  if (prior.attitude_is_measured) {
    const Mat3 attitude = prior.covariance.topLeftCorner<3, 3>();
    if (!invert_positive_definite<3>(attitude, information)) return false;
  }
  const double distance = (prior.camera_from_map * sightings.front().place).z();
  if (!(distance > 0)) return false;
  pose.camera_from_map = prior.camera_from_map;
  PoseCovariance normal;  // of the sightings
  for (int step = 0; step < most_steps; ++step) {
    measure(sightings, pose.camera_from_map, params.pixel_m);
    const double spread = sigma_of_median * params.sigma_px * median_size(sightings, params.sigma_px);
    const double sigma_px = std::max(params.sigma_px, params.together * spread);
    normal.setZero();
    Vec6 gradient = Vec6::Zero();
    pose.used = 0;
    for (MapSighting& sighting : sightings) {
      const double size = sighting.residual.norm() / sigma_px;
      sighting.weight = size < huber ? 1 : (size < left_out ? huber / size : 0);
      if (sighting.weight == 0) continue;
      Vec2 residual;
      Eigen::Matrix<double, 2, 6> by;
      if (!sighting_residual(pose.camera_from_map, sighting, residual, by)) continue;
      const double per_unit = px_per_unit(pose.camera_from_map, sighting.place, params.pixel_m) / sigma_px;
      const double weight = sighting.weight * per_unit * per_unit;
      normal += weight * (by.transpose().lazyProduct(by));
      gradient += weight * (by.transpose() * residual);
      ++pose.used;
    }
    if (pose.used < least_used) return false;
    if (prior.attitude_is_measured) gradient += attitude_gradient(pose.camera_from_map, prior, information);
    if (!invert_information(with_attitude(normal, information), distance, pose.covariance)) return false;
    const Vec6 change = -(pose.covariance.lazyProduct(gradient));
    if (!change.allFinite()) return false;
    pose.camera_from_map = changed_pose(pose.camera_from_map, change);
    if (change.head<3>().norm() < 1e-8 && change.tail<3>().norm() < 1e-8 * distance) break;
  }
  for (int k = 0; k < 3; ++k) {
    if (!(pose.covariance(k, k) < widest_attitude_rad * widest_attitude_rad)) return false;
  }
  double q[4];
  quaternion_from_rotation(pose.camera_from_map.rotation, q);
  const Vec3 centre = camera_centre(pose.camera_from_map);
  pose.camera_from_map.rotation = rotation_from_quaternion(q);
  pose.camera_from_map.translation = -(pose.camera_from_map.rotation * centre);
  measure(sightings, pose.camera_from_map, params.pixel_m);
  double squares = 0;
  for (const MapSighting& sighting : sightings) {
    if (sighting.weight > 0) squares += sighting.residual.squaredNorm();
  }
  pose.residual_px = std::sqrt(squares / (2.0 * pose.used));
  // The pose has fitted a part of the residuals away, the more the fewer of them are independent. What an attitude has
  // determined was not fitted.
  constexpr double least_left = 1;
  const Mat3 attitude = pose.covariance.topLeftCorner<3, 3>();
  const double unknowns = 6 - (information * attitude).trace();
  const double independent = 2.0 * pose.used / (params.together * params.together);
  const double grown = std::max(independent, unknowns + least_left) / std::max(independent - unknowns, least_left);
  if (!invert_information(with_attitude(normal / grown, information), distance, pose.covariance)) return false;
  const double by_spread = (params.common_share + params.common_growth * pose.residual_px) * pose.residual_px;
  constexpr double common_sigma_px = 0.02;  // at least
  const double common = params.pixel_m * std::sqrt(common_sigma_px * common_sigma_px + by_spread * by_spread);
  for (int k = 3; k < 6; ++k) pose.covariance(k, k) += common * common;
  return pose.camera_from_map.rotation.allFinite() && centre.allFinite();
}

}  // namespace ilp
