#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::bundle {
namespace {

bool all_finite(const double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) return false;
  }
  return true;
}

bool usable(const BundleCamera& camera) {
  const double intrinsics[] = {camera.fx, camera.fy, camera.cx, camera.cy};
  const double* q = camera.pose.q_cam_from_world;
  if (!all_finite(intrinsics, 4) || !all_finite(q, 4) || !all_finite(camera.pose.centre, 3)) return false;
  const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return camera.fx > 0 && camera.fy > 0 && std::fabs(norm2 - 1) < 1e-6;
}

double distance(const double a[3], const double b[3]) {
  const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

Status sort_observations(Equations& eq) {
  const std::size_t points = eq.problem->points.size();
  const std::size_t count = eq.problem->observations.size();
  for (std::size_t p = 0; p <= points; ++p) eq.offsets[p] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const BundleObservation& o = eq.problem->observations[i];
    if (o.camera >= eq.problem->cameras.size() || o.point >= points || !std::isfinite(o.x) || !std::isfinite(o.y)) {
      return out_of_range(Argument::observation, i);
    }
    ++eq.offsets[o.point];
  }
  std::uint32_t sum = 0;
  for (std::size_t p = 0; p <= points; ++p) {
    const std::uint32_t here = eq.offsets[p];
    eq.offsets[p] = sum;
    sum += here;
  }
  // Counting sort by point: each offset advances to the end of its point. Then insertion by camera inside a point, so
  // that free cameras come in ascending order.
  for (std::size_t i = 0; i < count; ++i) {
    const BundleObservation& o = eq.problem->observations[i];
    eq.observations[eq.offsets[o.point]++] = {o.x, o.y, o.camera};
  }
  std::uint32_t first = 0;
  for (std::size_t p = 0; p < points; ++p) {
    const std::uint32_t last = eq.offsets[p];
    for (std::uint32_t i = first + 1; i < last; ++i) {
      const Observation moving = eq.observations[i];
      std::uint32_t at = i;
      for (; at > first && eq.observations[at - 1].camera > moving.camera; --at)
        eq.observations[at] = eq.observations[at - 1];
      eq.observations[at] = moving;
      if (at > first && eq.observations[at - 1].camera == moving.camera) {
        return out_of_range(Argument::observation, p);
      }
    }
    eq.spans[p] = {first, last, 0, static_cast<std::uint16_t>(p)};
    first = last;
  }
  eq.span_count = points;
  return {};
}

void choose_active(Equations& eq) {
  std::size_t kept_spans = 0;
  std::uint32_t kept = 0;
  for (std::size_t s = 0; s < eq.span_count; ++s) {
    const PointSpan span = eq.spans[s];
    const double* x = eq.problem->points[span.point].position;
    const std::uint32_t first = kept;
    std::uint32_t cameras = 0;
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      const Camera& camera = eq.cameras[eq.observations[i].camera];
      double depth = 0;
      for (int k = 0; k < 3; ++k) depth += camera.rotation[6 + k] * (x[k] - camera.centre[k]);
      if (!(depth > 0)) continue;
      cameras |= 1U << eq.observations[i].camera;
      eq.observations[kept++] = eq.observations[i];
    }
    if (kept - first < 2) {
      kept = first;
      continue;
    }
    eq.spans[kept_spans++] = {first, kept, cameras, span.point};
  }
  eq.span_count = kept_spans;
  eq.active_observations = kept;
}

Status load(Equations& eq, BundleProblem& problem, const BundleParams& params) {
  eq.problem = nullptr;
  eq.params = params;
  if (!(params.relative_tolerance >= 0) || !(params.robust_px >= 0) || !std::isfinite(params.robust_px)) {
    return out_of_range(Argument::adjustment_parameters);
  }
  eq.free_count = 0;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    if (!usable(problem.cameras[i])) return out_of_range(Argument::camera, i);
    eq.cameras[i] = camera_from(problem.cameras[i]);
    if (problem.cameras[i].fixed) continue;
    eq.cameras[i].free = true;
    eq.cameras[i].block = static_cast<std::uint32_t>(eq.free_count);
    eq.camera_of_free[eq.free_count++] = static_cast<std::uint16_t>(i);
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (!all_finite(problem.points[i].position, 3)) {
      return out_of_range(Argument::point, i);
    }
  }
  const std::size_t count = problem.cameras.size();
  const BundleScaleHold& hold = problem.hold;
  if (hold.held && (hold.origin >= count || hold.anchor >= count || hold.origin == hold.anchor ||
                    eq.free_count + 1 != count || !problem.cameras[hold.origin].fixed)) {
    return out_of_range(Argument::scale_hold);
  }
  eq.problem = &problem;
  const Status sorted = sort_observations(eq);
  if (!sorted.ok()) {
    eq.problem = nullptr;
    return sorted;
  }
  choose_active(eq);
  pair_points(eq);
  return {};
}

Cost try_step(Equations& eq, double& predicted_twice) {
  for (std::size_t a = 0; a < eq.problem->cameras.size(); ++a) eq.trial_cameras[a] = eq.cameras[a];
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    Camera& camera = eq.trial_cameras[eq.camera_of_free[a]];
    const double* step = &eq.camera_step[camera_size * a];
    Mat3 rotation;
    for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = camera.rotation[i];
    // Uses the quaternion that the problem stores, so that a resumed adjustment starts from the same bits.
    double q[4];
    quaternion_from_rotation(rotation_from_vector(Vec3(step[0], step[1], step[2])) * rotation, q);
    rotation = rotation_from_quaternion(q);
    for (int i = 0; i < 4; ++i) eq.trial_quaternions[a][static_cast<std::size_t>(i)] = q[i];
    for (int i = 0; i < 9; ++i) camera.rotation[i] = rotation(i / 3, i % 3);
    for (int i = 0; i < 3; ++i) camera.centre[i] += step[3 + i];
  }
  Cost cost = step_all_points(eq, predicted_twice);
  if (!std::isfinite(cost.robust) || !std::isfinite(predicted_twice)) cost.valid = false;
  return cost;
}

void accept(Equations& eq) {
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    const std::uint16_t index = eq.camera_of_free[a];
    eq.cameras[index] = eq.trial_cameras[index];
    Pose& pose = eq.problem->cameras[index].pose;
    for (std::size_t i = 0; i < 4; ++i) pose.q_cam_from_world[i] = eq.trial_quaternions[a][i];
    for (int i = 0; i < 3; ++i) pose.centre[i] = eq.cameras[index].centre[i];
  }
  for (std::size_t s = 0; s < eq.span_count; ++s) {
    const std::uint16_t point = eq.spans[s].point;
    eq.problem->points[point] = eq.trial_points[point];
  }
}

void hold_scale(Equations& eq, double held_distance) {
  if (!eq.problem->hold.held) return;
  const double* origin = eq.cameras[eq.problem->hold.origin].centre;
  const double factor = held_distance / distance(origin, eq.cameras[eq.problem->hold.anchor].centre);
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    Camera& camera = eq.cameras[eq.camera_of_free[a]];
    double* stored = eq.problem->cameras[eq.camera_of_free[a]].pose.centre;
    for (int k = 0; k < 3; ++k) stored[k] = camera.centre[k] = origin[k] + factor * (camera.centre[k] - origin[k]);
  }
  for (std::size_t s = 0; s < eq.span_count; ++s) {
    double* x = eq.problem->points[eq.spans[s].point].position;
    for (int k = 0; k < 3; ++k) x[k] = origin[k] + factor * (x[k] - origin[k]);
  }
}

}  // namespace

Camera camera_from(const BundleCamera& camera) {
  Camera to{};
  const Mat3 rotation = rotation_from_quaternion(camera.pose.q_cam_from_world);
  for (int i = 0; i < 9; ++i) to.rotation[i] = rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) to.centre[i] = camera.pose.centre[i];
  to.fx = camera.fx;
  to.fy = camera.fy;
  to.cx = camera.cx;
  to.cy = camera.cy;
  return to;
}

}  // namespace ilp::bundle

namespace ilp {
namespace {

struct BundleSteps {
  bundle::Equations& equations;

  bool try_step(double damping, TrialStep& trial) {
    double predicted_twice = 0;
    if (!bundle::linearise(equations, damping)) return false;
    bundle::assemble(equations, damping);
    if (!bundle::solve_cameras(equations, damping, predicted_twice)) return false;
    const bundle::Cost cost = bundle::try_step(equations, predicted_twice);
    trial = {0.5 * cost.robust, 0.5 * predicted_twice};
    return cost.valid;
  }
  void accept() { bundle::accept(equations); }
};

}  // namespace

Status BundleAdjuster::begin(BundleProblem& problem, const BundleParams& params) {
  ILP_TRY(bundle::load(equations_, problem, params));
  progress_ = {};
  const bundle::Cost cost = bundle::evaluate(equations_);
  if (equations_.active_observations == 0 || !cost.valid) {
    equations_.problem = nullptr;
    return {StatusCode::no_model, 0, static_cast<std::int64_t>(problem.observations.size())};
  }
  progress_.descent.cost = progress_.initial_cost = 0.5 * cost.robust;
  progress_.initial_rms_px = std::sqrt(cost.squared / (2.0 * static_cast<double>(equations_.active_observations)));
  progress_.descent.done = params.max_iterations == 0 || cost.robust == 0;
  progress_.descent.converged = cost.robust == 0;
  if (problem.hold.held) {
    const bundle::Camera& origin = equations_.cameras[problem.hold.origin];
    const bundle::Camera& anchor = equations_.cameras[problem.hold.anchor];
    progress_.held_distance = bundle::distance(origin.centre, anchor.centre);
    if (!(progress_.held_distance > 0)) {
      equations_.problem = nullptr;
      return out_of_range(Argument::scale_hold, progress_.held_distance);
    }
  }
  return {};
}

Status BundleAdjuster::resume(BundleProblem& problem, const BundleParams& params, const BundleProgress& progress) {
  ILP_TRY(bundle::load(equations_, problem, params));
  progress_ = progress;
  return {};
}

Status BundleAdjuster::step() {
  ILP_ASSERT(equations_.problem != nullptr, 0);
  if (progress_.descent.done) return {};
  BundleSteps steps{equations_};
  const BundleParams& params = equations_.params;
  levenberg_marquardt_step(steps, params.max_iterations, params.relative_tolerance, progress_.descent);
  return {};
}

Status BundleAdjuster::finish(BundleResult& result, BundleCovariance* joint) {
  ILP_ASSERT(equations_.problem != nullptr, 0);
  result = {};
  bundle::hold_scale(equations_, progress_.held_distance);
  const bundle::Cost cost = bundle::evaluate(equations_);
  const auto observations = static_cast<double>(equations_.active_observations);
  result.initial_cost = progress_.initial_cost;
  result.final_cost = 0.5 * cost.robust;
  result.initial_rms_px = progress_.initial_rms_px;
  result.final_rms_px = std::sqrt(cost.squared / (2 * observations));
  result.iterations = progress_.descent.iterations;
  result.converged = progress_.descent.converged;
  result.points = static_cast<std::uint32_t>(equations_.span_count);
  result.observations = static_cast<std::uint32_t>(equations_.active_observations);
  result.dropped_observations =
      static_cast<std::uint32_t>(equations_.problem->observations.size() - equations_.active_observations);
  bundle::covariances(equations_, result, joint);
  equations_.problem = nullptr;
  return {};
}

Status BundleAdjuster::run(BundleProblem& problem, const BundleParams& params, BundleResult& result,
                           BundleCovariance* joint) {
  ILP_TRY(begin(problem, params));
  while (!progress_.descent.done) ILP_TRY(step());  // bound: the steps of `max_iterations`
  return finish(result, joint);
}

}  // namespace ilp
