#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr double max_damping = 1e16;
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

}  // namespace

bundle::Camera bundle::camera_from(const BundleCamera& camera, std::int32_t free_index) {
  Camera to{};
  const Mat3 rotation = rotation_from_quaternion(camera.pose.q_cam_from_world);
  for (int i = 0; i < 9; ++i) to.rotation[i] = rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) to.centre[i] = camera.pose.centre[i];
  to.fx = camera.fx;
  to.fy = camera.fy;
  to.cx = camera.cx;
  to.cy = camera.cy;
  to.free_index = free_index;
  return to;
}

Status BundleAdjuster::load(BundleProblem& problem, const BundleParams& params) {
  problem_ = nullptr;
  params_ = params;
  if (!(params.relative_tolerance >= 0) || !(params.robust_px >= 0) || !std::isfinite(params.robust_px) ||
      !(params.initial_damping > 0) || !std::isfinite(params.initial_damping) || !(params.observation_sigma_px > 0) ||
      !std::isfinite(params.observation_sigma_px) || params.loss > BundleLoss::cauchy) {
    return out_of_range(Argument::adjustment_parameters);
  }
  free_count_ = 0;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    if (!usable(problem.cameras[i])) return out_of_range(Argument::camera, i);
    cameras_[i].free_index = -1;
    if (!problem.cameras[i].fixed) {
      cameras_[i].free_index = static_cast<std::int32_t>(free_count_);
      camera_of_free_[free_count_++] = static_cast<std::uint16_t>(i);
    }
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (!all_finite(problem.points[i].position, 3)) {
      return out_of_range(Argument::point, i);
    }
  }
  const auto count = static_cast<std::int32_t>(problem.cameras.size());
  const BundleScaleHold& hold = problem.hold;
  if (hold.origin >= count || hold.anchor >= count || (hold.origin < 0) != (hold.anchor < 0) ||
      (hold.origin >= 0 &&
       (free_count_ + 1 != problem.cameras.size() || !problem.cameras[static_cast<std::size_t>(hold.origin)].fixed ||
        hold.origin == hold.anchor))) {
    return out_of_range(Argument::scale_hold);
  }
  ILP_TRY(check_priors(problem));
  problem_ = &problem;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i)
    cameras_[i] = bundle::camera_from(problem.cameras[i], cameras_[i].free_index);
  const Status sorted = sort_observations();
  if (!sorted.ok()) {
    problem_ = nullptr;
    return sorted;
  }
  choose_active();
  pair_points();
  return {};
}

Status BundleAdjuster::sort_observations() {
  const std::size_t points = problem_->points.size();
  const std::size_t count = problem_->observations.size();
  for (std::size_t p = 0; p <= points; ++p) offsets_[p] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const BundleObservation& o = problem_->observations[i];
    if (o.camera >= problem_->cameras.size() || o.point >= points || !std::isfinite(o.x) || !std::isfinite(o.y)) {
      return out_of_range(Argument::observation, i);
    }
    ++offsets_[o.point];
  }
  std::uint32_t sum = 0;
  for (std::size_t p = 0; p <= points; ++p) {
    const std::uint32_t here = offsets_[p];
    offsets_[p] = sum;
    sum += here;
  }
  // Counting sort by point: each offset advances to the end of its point. Then insertion by camera inside a point, so
  // that free cameras come in ascending order.
  for (std::size_t i = 0; i < count; ++i) {
    const BundleObservation& o = problem_->observations[i];
    observations_[offsets_[o.point]++] = {o.x, o.y, o.camera};
  }
  std::uint32_t first = 0;
  for (std::size_t p = 0; p < points; ++p) {
    const std::uint32_t last = offsets_[p];
    for (std::uint32_t i = first + 1; i < last; ++i) {
      const Observation moving = observations_[i];
      std::uint32_t at = i;
      for (; at > first && observations_[at - 1].camera > moving.camera; --at)
        observations_[at] = observations_[at - 1];
      observations_[at] = moving;
      if (at > first && observations_[at - 1].camera == moving.camera) {
        return out_of_range(Argument::observation, p);
      }
    }
    spans_[p] = {first, last, 0, static_cast<std::uint16_t>(p)};
    first = last;
  }
  span_count_ = points;
  return {};
}

void BundleAdjuster::choose_active() {
  std::size_t kept_spans = 0;
  std::uint32_t kept = 0;
  for (std::size_t s = 0; s < span_count_; ++s) {
    const PointSpan span = spans_[s];
    const double* x = problem_->points[span.point].position;
    const std::uint32_t first = kept;
    std::uint32_t cameras = 0;
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      const Camera& camera = cameras_[observations_[i].camera];
      double depth = 0;
      for (int k = 0; k < 3; ++k) depth += camera.rotation[6 + k] * (x[k] - camera.centre[k]);
      if (!(depth > 0)) continue;
      cameras |= 1U << observations_[i].camera;
      observations_[kept++] = observations_[i];
    }
    if (kept - first < 2) {
      kept = first;
      continue;
    }
    spans_[kept_spans++] = {first, kept, cameras, span.point};
  }
  span_count_ = kept_spans;
  active_observations_ = kept;
}

Status BundleAdjuster::begin(BundleProblem& problem, const BundleParams& params) {
  ILP_TRY(load(problem, params));
  progress_ = {};
  progress_.damping = params.initial_damping;
  const Cost cost = evaluate();
  if (active_observations_ == 0 || !cost.valid) {
    problem_ = nullptr;
    return {StatusCode::no_model, 0, static_cast<std::int64_t>(problem.observations.size())};
  }
  progress_.cost = progress_.initial_cost = 0.5 * cost.robust;
  progress_.initial_rms_px = std::sqrt(cost.squared / (2.0 * static_cast<double>(active_observations_)));
  progress_.done = params.max_iterations == 0 || cost.robust == 0;
  progress_.converged = cost.robust == 0;
  if (problem.hold.origin >= 0) {
    const Camera& origin = cameras_[static_cast<std::size_t>(problem.hold.origin)];
    const Camera& anchor = cameras_[static_cast<std::size_t>(problem.hold.anchor)];
    progress_.held_distance = distance(origin.centre, anchor.centre);
    if (!(progress_.held_distance > 0)) {
      problem_ = nullptr;
      return out_of_range(Argument::scale_hold, progress_.held_distance);
    }
  }
  return {};
}

Status BundleAdjuster::resume(BundleProblem& problem, const BundleParams& params, const BundleProgress& progress) {
  ILP_TRY(load(problem, params));
  progress_ = progress;
  return {};
}

BundleAdjuster::Cost BundleAdjuster::try_step(double& predicted_twice) {
  for (std::size_t a = 0; a < problem_->cameras.size(); ++a) trial_cameras_[a] = cameras_[a];
  for (std::size_t a = 0; a < free_count_; ++a) {
    Camera& camera = trial_cameras_[camera_of_free_[a]];
    const double* step = &camera_step_[camera_size * a];
    Mat3 rotation;
    for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = camera.rotation[i];
    // Uses the quaternion that the problem stores, so that a resumed adjustment starts from the same bits.
    double q[4];
    quaternion_from_rotation(rotation_from_vector(Vec3(step[0], step[1], step[2])) * rotation, q);
    rotation = rotation_from_quaternion(q);
    for (int i = 0; i < 4; ++i) trial_quaternions_[a][static_cast<std::size_t>(i)] = q[i];
    for (int i = 0; i < 9; ++i) camera.rotation[i] = rotation(i / 3, i % 3);
    for (int i = 0; i < 3; ++i) camera.centre[i] += step[3 + i];
  }
  Cost cost = step_all_points(predicted_twice);
  cost.robust += prior_cost(trial_cameras_);
  if (!std::isfinite(cost.robust) || !std::isfinite(predicted_twice)) cost.valid = false;
  return cost;
}

void BundleAdjuster::accept(double cost) {
  progress_.cost = cost;
  for (std::size_t a = 0; a < free_count_; ++a) {
    const std::uint16_t index = camera_of_free_[a];
    cameras_[index] = trial_cameras_[index];
    Pose& pose = problem_->cameras[index].pose;
    for (std::size_t i = 0; i < 4; ++i) pose.q_cam_from_world[i] = trial_quaternions_[a][i];
    for (int i = 0; i < 3; ++i) pose.centre[i] = cameras_[index].centre[i];
  }
  for (std::size_t s = 0; s < span_count_; ++s) {
    const std::uint16_t point = spans_[s].point;
    problem_->points[point] = trial_points_[point];
  }
}

Status BundleAdjuster::step() {
  ILP_ASSERT(problem_ != nullptr, 0);
  if (progress_.done) return {};
  ++progress_.iterations;
  double predicted_twice = 0;
  bool accepted = false;
  bool solved = linearise(progress_.damping);
  if (solved) {
    assemble(progress_.damping);
    solved = solve_cameras(predicted_twice);
  }
  if (solved) {
    const Cost trial = try_step(predicted_twice);
    const double gain = progress_.cost - 0.5 * trial.robust;
    const double predicted = 0.5 * predicted_twice;
    const double negligible = params_.relative_tolerance * progress_.cost;
    if (trial.valid && gain >= 0) {
      accepted = true;
      accept(0.5 * trial.robust);
      const double ratio = predicted > 0 ? gain / predicted : 1;
      const double centred = 2 * ratio - 1;
      const double shrink = 1 - centred * centred * centred;
      progress_.damping *= shrink > 1.0 / 3 ? shrink : 1.0 / 3;
      progress_.damping_growth = 2;
      progress_.converged = gain <= negligible;
    } else {
      // A worse cost with almost no predicted gain is rounding: the minimum is reached.
      progress_.converged = trial.valid && predicted <= negligible;
    }
  }
  if (!accepted) {
    progress_.damping *= progress_.damping_growth;
    progress_.damping_growth *= 2;
  }
  progress_.done =
      progress_.converged || progress_.iterations >= params_.max_iterations || !(progress_.damping < max_damping);
  return {};
}

void BundleAdjuster::hold_scale() {
  if (problem_->hold.origin < 0) return;
  const double* origin = cameras_[static_cast<std::size_t>(problem_->hold.origin)].centre;
  const double factor =
      progress_.held_distance / distance(origin, cameras_[static_cast<std::size_t>(problem_->hold.anchor)].centre);
  for (std::size_t a = 0; a < free_count_; ++a) {
    Camera& camera = cameras_[camera_of_free_[a]];
    double* stored = problem_->cameras[camera_of_free_[a]].pose.centre;
    for (int k = 0; k < 3; ++k) stored[k] = camera.centre[k] = origin[k] + factor * (camera.centre[k] - origin[k]);
  }
  for (std::size_t s = 0; s < span_count_; ++s) {
    double* x = problem_->points[spans_[s].point].position;
    for (int k = 0; k < 3; ++k) x[k] = origin[k] + factor * (x[k] - origin[k]);
  }
}

Status BundleAdjuster::finish(BundleResult& result, BundleCovariance* joint) {
  ILP_ASSERT(problem_ != nullptr, 0);
  result = {};
  hold_scale();
  const Cost cost = evaluate();
  const auto observations = static_cast<double>(active_observations_);
  result.initial_cost = progress_.initial_cost;
  result.final_cost = 0.5 * cost.robust;
  result.initial_rms_px = progress_.initial_rms_px;
  result.final_rms_px = std::sqrt(cost.squared / (2 * observations));
  result.iterations = progress_.iterations;
  result.converged = progress_.converged;
  result.points = static_cast<std::uint32_t>(span_count_);
  result.observations = static_cast<std::uint32_t>(active_observations_);
  result.dropped_observations = static_cast<std::uint32_t>(problem_->observations.size() - active_observations_);
  covariances(result, joint);
  problem_ = nullptr;
  return {};
}

Status BundleAdjuster::run(BundleProblem& problem, const BundleParams& params, BundleResult& result,
                           BundleCovariance* joint) {
  ILP_TRY(begin(problem, params));
  while (!progress_.done) ILP_TRY(step());  // bound: the steps of `max_iterations`
  return finish(result, joint);
}

}  // namespace ilp
