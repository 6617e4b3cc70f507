#include "sim/ground/model/point_refinement.hpp"

#include <Eigen/LU>
#include <optional>

namespace ilp::model {
namespace {

constexpr int least_refinements = 2, most_refinements = 6;
/// A step that takes no more from the squares is the last one, px^2.
constexpr double refined = 1e-4;

/// By how much the squares fall, px^2. None where the sightings do not determine the point, or it would leave the view.
std::optional<double> step_point(const Scene& scene, const Model& model, std::size_t track, double robust_px,
                                 Vec3& point) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t s = 0; s < scene.tracks[track].seen.size(); ++s) {
    if (!model.sees(scene, track, s)) continue;
    const Sighting& seen = scene.tracks[track].seen[s];
    const CameraModel& camera = scene.views[seen.view].camera;
    const RigidTransform& pose = model.views[seen.view].camera_from_model;
    const Vec3 p = pose * point;
    if (!(p.z() > 0)) return std::nullopt;
    const double u = p.x() / p.z(), v = p.y() / p.z();
    const Vec2 error(camera.fx * u + camera.cx - seen.x, camera.fy * v + camera.cy - seen.y);
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << camera.fx, 0, -camera.fx * u, 0, camera.fy, -camera.fy * v;
    by_point = (by_point / p.z() * pose.rotation).eval();
    const double weight = 1 / (1 + error.squaredNorm() / (robust_px * robust_px));
    normal.noalias() += weight * by_point.transpose() * by_point;
    right.noalias() -= weight * by_point.transpose() * error;
  }
  const Vec3 move = normal.inverse() * right;
  if (!move.allFinite()) return std::nullopt;
  point += move;
  return move.dot(right);
}

}  // namespace

void refine_points(const Scene& scene, double robust_px, Model& model) {
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    ModelPoint& point = model.points[t];
    if (!point.placed || point.by_depth) continue;
    Vec3 position = point.position;
    std::optional<double> fall;
    for (int step = 0; step < most_refinements; ++step) {
      fall = step_point(scene, model, t, robust_px, position);
      if (!fall || (step + 1 >= least_refinements && *fall < refined)) break;
    }
    if (fall) point.position = position;
  }
}

}  // namespace ilp::model
