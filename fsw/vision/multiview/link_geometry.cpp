#include "fsw/vision/multiview/link_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/symmetric_solver.hpp"
#include "fsw/vision/image/small_solver.hpp"

namespace ilp {
namespace {

constexpr int refinement_steps = 12;

/// Sums of the normal equations over residuals that were divided by their estimated errors.
struct NormalEquations {
  SimilarityCovariance normal = SimilarityCovariance::Zero();
  SimilarityStep gradient = SimilarityStep::Zero();
  double squares = 0;
  int residuals = 0;

  /// Residuals of one match with their covariance; they are weighted down together when they are large.
  template <int N>
  void add(Eigen::Matrix<double, N, 1> residual, Eigen::Matrix<double, N, 7> derivative,
           const Eigen::Matrix<double, N, N>& covariance) {
    constexpr double robust = 2;
    double factor[N][N];
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) factor[i][j] = covariance(i, j);
    }
    if (!factor_positive_definite(factor, 1e-12)) return;
    // Forward substitution with the factor makes the residuals independent with unit variance.
    for (int i = 0; i < N; ++i) {
      for (int k = 0; k < i; ++k) {
        residual(i) -= factor[i][k] * residual(k);
        derivative.row(i) -= factor[i][k] * derivative.row(k);
      }
      residual(i) /= factor[i][i];
      derivative.row(i) /= factor[i][i];
    }
    const double norm = residual.norm();
    const double weight = norm > robust ? robust / norm : 1;
    normal += weight * (derivative.transpose() * derivative);
    gradient += weight * (derivative.transpose() * residual);
    squares += residual.squaredNorm();
    residuals += N;
  }
};

Vec3 ray(const CameraModel& camera, double x, double y) {
  const Vec2 normalised = normalised_from_ideal(camera, Vec2(x, y));
  return {normalised.x(), normalised.y(), 1};
}

struct Projected {
  Vec2 error;  ///< px
  Eigen::Matrix<double, 2, 3> derivative;
};

Projected project(const CameraModel& camera, const Vec3& x, double seen_x, double seen_y) {
  const double inverse = 1 / x.z();
  const Vec2 ideal = ideal_from_normalised(camera, Vec2(x.x() * inverse, x.y() * inverse));
  Projected projected;
  projected.error = ideal - Vec2(seen_x, seen_y);
  projected.derivative << camera.fx * inverse, 0, -camera.fx * x.x() * inverse * inverse, 0, camera.fy * inverse,
      -camera.fy * x.y() * inverse * inverse;
  return projected;
}

/// Errors of one match in both images, px; a large one where a point lies behind a camera.
double largest_error(const LinkMatch& match, const CameraModel& camera, const Similarity& b_from_a) {
  constexpr double behind = 1e9;
  double largest = 0;
  if (match.place_inverse_depth > 0) {
    const Vec3 x = b_from_a * Vec3(ray(camera, match.place_x, match.place_y) / match.place_inverse_depth);
    if (!(x.z() > 0)) return behind;
    largest = project(camera, x, match.x, match.y).error.norm();
  }
  if (match.inverse_depth > 0) {
    const Vec3 x = inverse(b_from_a) * Vec3(ray(camera, match.x, match.y) / match.inverse_depth);
    if (!(x.z() > 0)) return behind;
    largest = std::max(largest, project(camera, x, match.place_x, match.place_y).error.norm());
  }
  return largest;
}

/// The point that the one keyframe sees, in the other image and, if the depth is known there too, at its depth. The
/// errors are those of both features, and that of the point's depth, which moves it in the other image.
void add_match(const LinkMatch& match, const CameraModel& camera, const LinkGeometryParams& params,
               const Similarity& b_from_a, NormalEquations& sums) {
  const double feature = 2 * params.feature_sigma_px * params.feature_sigma_px;
  const double depth = params.depth_sigma * params.depth_sigma;
  if (match.place_inverse_depth > 0) {
    const Vec3 x = b_from_a * Vec3(ray(camera, match.place_x, match.place_y) / match.place_inverse_depth);
    const Vec3 by_depth = x - b_from_a.translation;
    const Eigen::Matrix<double, 3, 7> change = change_by_step(x);
    const Projected projected = project(camera, x, match.x, match.y);
    if (!(match.inverse_depth > 0)) {
      const Vec2 moved = projected.derivative * by_depth;
      const Eigen::Matrix2d covariance = feature * Eigen::Matrix2d::Identity() + depth * moved * moved.transpose();
      sums.add<2>(projected.error, projected.derivative * change, covariance);
      return;
    }
    Vec3 residual;
    residual << projected.error, det_log(x.z() * match.inverse_depth);
    Mat3 map;
    map << projected.derivative, 0, 0, 1 / x.z();
    const Vec3 moved = map * by_depth;
    const Mat3 covariance = Mat3(Vec3(feature, feature, depth).asDiagonal()) + depth * moved * moved.transpose();
    sums.add<3>(residual, map * change, covariance);
  } else if (match.inverse_depth > 0) {
    const Vec3 seen = ray(camera, match.x, match.y) / match.inverse_depth;
    const Mat3 back = b_from_a.rotation.transpose() / b_from_a.scale;
    const Projected projected = project(camera, inverse(b_from_a) * seen, match.place_x, match.place_y);
    const Vec2 moved = projected.derivative * (back * seen);
    const Eigen::Matrix2d covariance = feature * Eigen::Matrix2d::Identity() + depth * moved * moved.transpose();
    sums.add<2>(projected.error, -(projected.derivative * back) * change_by_step(seen), covariance);
  }
}

NormalEquations sums_over(const LinkMatches& matches, const ViewMask& inliers, const CameraModel& camera,
                          const LinkGeometryParams& params, const Similarity& b_from_a) {
  NormalEquations sums;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (inliers[i] != 0) add_match(matches[i], camera, params, b_from_a, sums);
  }
  return sums;
}

std::uint32_t select(const LinkMatches& matches, const CameraModel& camera, double threshold_px,
                     const Similarity& b_from_a, ViewMask& inliers) {
  static_cast<void>(inliers.resize(matches.size()));
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool deep = matches[i].place_inverse_depth > 0 || matches[i].inverse_depth > 0;
    inliers[i] = deep && largest_error(matches[i], camera, b_from_a) < threshold_px ? 1 : 0;
    count += inliers[i];
  }
  return count;
}

/// The newer camera in the place's frame, and the unit of its strip by the depths of both.
Status first_similarity(const LinkMatches& matches, const CameraModel& camera, const LinkGeometryParams& params,
                        LinkGeometryWorkspace& workspace, Similarity& b_from_a) {
  workspace.views.clear();
  for (const LinkMatch& match : matches) {
    if (!(match.place_inverse_depth > 0)) continue;
    const Vec3 point = ray(camera, match.place_x, match.place_y) / match.place_inverse_depth;
    static_cast<void>(workspace.views.push_back({{point.x(), point.y(), point.z()}, match.x, match.y}));
  }
  if (workspace.views.size() < params.min_inliers) {
    return {StatusCode::too_few_matches, static_cast<std::int64_t>(workspace.views.size())};
  }
  ResectionParams resection;
  resection.threshold_px = params.threshold_px;
  resection.min_inliers = params.min_inliers;
  resection.robust_px = params.feature_sigma_px;
  resection.seed = params.seed;
  ResectionResult camera_in_place;
  ILP_TRY(resect(workspace.views, camera, resection, workspace.inliers, camera_in_place));
  std::array<double, limits::max_place_patches> quotients{};
  std::size_t count = 0;
  std::size_t view = 0;
  for (const LinkMatch& match : matches) {
    if (!(match.place_inverse_depth > 0)) continue;
    const bool inlier = workspace.inliers[view] != 0;
    const PointView& point = workspace.views[view++];
    if (!inlier || !(match.inverse_depth > 0)) continue;
    const Vec3 x = camera_in_place.cam_from_world * Vec3(point.position[0], point.position[1], point.position[2]);
    quotients[count++] = 1 / (match.inverse_depth * x.z());
  }
  if (count < params.min_inliers) return {StatusCode::too_few_matches, static_cast<std::int64_t>(count)};
  const auto middle = quotients.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(quotients.begin(), middle, quotients.begin() + static_cast<std::ptrdiff_t>(count));
  b_from_a = similarity_from(camera_in_place.cam_from_world);
  b_from_a.scale = *middle;
  b_from_a.translation *= *middle;
  return {};
}

}  // namespace

Status estimate_link(const LinkMatches& matches, const CameraModel& camera, const LinkGeometryParams& params,
                     LinkGeometryWorkspace& workspace, LinkGeometry& geometry) {
  Similarity b_from_a;
  ILP_TRY(first_similarity(matches, camera, params, workspace, b_from_a));
  for (int step = 0; step < refinement_steps; ++step) {
    if (select(matches, camera, params.threshold_px, b_from_a, workspace.inliers) < params.min_inliers) {
      return {StatusCode::no_model, static_cast<std::int64_t>(matches.size())};
    }
    const NormalEquations sums = sums_over(matches, workspace.inliers, camera, params, b_from_a);
    const SimilarityStep change = -solve_symmetric<7>(sums.normal, sums.gradient);
    if (!change.allFinite()) return {StatusCode::no_model, 0};
    b_from_a = stepped(change, b_from_a);
  }
  double q[4];
  quaternion_from_rotation(b_from_a.rotation, q);
  b_from_a.rotation = rotation_from_quaternion(q);
  geometry.inliers = select(matches, camera, params.threshold_px, b_from_a, workspace.inliers);
  const NormalEquations sums = sums_over(matches, workspace.inliers, camera, params, b_from_a);
  const bool finite = b_from_a.rotation.allFinite() && b_from_a.translation.allFinite() && b_from_a.scale > 0;
  if (geometry.inliers < params.min_inliers || !finite) return {StatusCode::no_model, geometry.inliers};
  geometry.keyframe_from_place = b_from_a;
  const double excess = std::max(1.0, sums.squares / std::max(1, sums.residuals - 7));
  geometry.covariance = excess * inverse_of_symmetric<7>(sums.normal);
  if (!geometry.covariance.allFinite()) return {StatusCode::no_model, geometry.inliers};
  double squares = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (workspace.inliers[i] == 0) continue;
    const double error = largest_error(matches[i], camera, b_from_a);
    squares += error * error;
  }
  geometry.rms_px = std::sqrt(squares / (2.0 * geometry.inliers));
  return {};
}

}  // namespace ilp
