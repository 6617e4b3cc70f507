#include "fsw/vision/twoview/solvers/triangulation.hpp"

#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/symmetric_solver.hpp"

namespace ilp {
namespace {

constexpr double min_depth = 1e-9;      // in units of the scene; nearer, the projection means nothing
constexpr double min_ray_angle = 1e-7;  // rad; below it the intersection is rounding error
constexpr int max_refinement_steps = 5;

/// Direction of the viewing ray in the world, unit length.
Vec3 ray_direction(const RayView& view) {
  const Vec3 direction(view.normalised.x(), view.normalised.y(), 1);
  return (view.cam_from_world.rotation.transpose() * direction).normalized();
}

double largest_ray_angle(const RayView* views, std::size_t count) {
  double best = 0;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Vec3 a = ray_direction(views[i]);
    for (std::size_t j = i + 1; j < count; ++j) {
      const Vec3 b = ray_direction(views[j]);
      best = std::fmax(best, det_atan2(a.cross(b).norm(), a.dot(b)));
    }
  }
  return best;
}

/// The point with the least sum of squared distances to all rays: sum (I - d d^T) (X - C) = 0.
bool midpoint(const RayView* views, std::size_t count, Vec3& position) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 direction = ray_direction(views[i]);
    const Mat3 projector = Mat3::Identity() - direction * direction.transpose();
    const RigidTransform& pose = views[i].cam_from_world;
    normal += projector;
    right -= projector * (pose.rotation.transpose() * pose.translation);
  }
  position = solve_symmetric<3>(normal, right);
  return position.allFinite();
}

struct Linearised {
  Mat3 normal = Mat3::Zero();
  Vec3 gradient = Vec3::Zero();
  double cost = 0;
  bool in_front = true;
};

Linearised linearise(const RayView* views, std::size_t count, const Vec3& position) {
  Linearised result;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = views[i].cam_from_world * position;
    if (!(p.z() > min_depth)) {
      result.in_front = false;
      return result;
    }
    const double inverse_depth = 1 / p.z();
    const double u = p.x() * inverse_depth;
    const double v = p.y() * inverse_depth;
    const double residual_u = u - views[i].normalised.x();
    const double residual_v = v - views[i].normalised.y();
    const Mat3& r = views[i].cam_from_world.rotation;
    const Vec3 row_u = (r.row(0) - u * r.row(2)).transpose() * inverse_depth;
    const Vec3 row_v = (r.row(1) - v * r.row(2)).transpose() * inverse_depth;
    result.normal += row_u * row_u.transpose() + row_v * row_v.transpose();
    result.gradient += row_u * residual_u + row_v * residual_v;
    result.cost += residual_u * residual_u + residual_v * residual_v;
  }
  return result;
}

/// Gauss-Newton on the reprojection error; a step without improvement is not taken.
void refine(const RayView* views, std::size_t count, Vec3& position) {
  Linearised here = linearise(views, count, position);
  if (!here.in_front) return;
  for (int step = 0; step < max_refinement_steps; ++step) {
    const Vec3 delta = solve_symmetric<3>(here.normal, here.gradient);
    if (!delta.allFinite()) return;
    const Vec3 candidate = position - delta;
    const Linearised there = linearise(views, count, candidate);
    if (!there.in_front || !(there.cost < here.cost)) return;
    position = candidate;
    const bool converged = here.cost - there.cost < 1e-9 * here.cost;
    here = there;
    if (converged) return;
  }
}

}  // namespace

Status triangulate(const RayView* views, std::size_t count, TriangulatedPoint& point) {
  point = {};
  if (count < 2) return out_of_range(Argument::views, count);
  point.angle_rad = largest_ray_angle(views, count);
  // Negated, so that NaN fails too.
  if (!(point.angle_rad > min_ray_angle) || !(point.angle_rad < pi - min_ray_angle)) {
    return {StatusCode::numerical_failure, 1};
  }
  if (!midpoint(views, count, point.position)) return {StatusCode::numerical_failure, 2};
  refine(views, count, point.position);

  point.in_front = true;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = views[i].cam_from_world * point.position;
    if (!(p.z() > min_depth)) point.in_front = false;
    const Vec2 residual = p.head<2>() / p.z() - views[i].normalised;
    point.max_error = std::fmax(point.max_error, residual.norm());
  }
  return {};
}

}  // namespace ilp
