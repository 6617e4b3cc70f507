#include "fsw/vision/multiview/bundle_adjustment.hpp"

#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle_observation.hpp"
#include "fsw/vision/multiview/dense_cholesky.hpp"

namespace ilp {
namespace {

constexpr std::size_t max_cameras = limits::max_bundle_cameras;
constexpr double max_damping = 1e16;
// Marquardt's scaling by the diagonal, kept away from zero so that an unseen direction still gets a damping.
constexpr double min_diagonal = 1e-6;

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

double damped_diagonal(double value) {
  return value < min_diagonal ? min_diagonal : value;
}

double distance(const double a[3], const double b[3]) {
  const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/// C -= A B^T for 6x3 A and B stored as three columns of six, C row-major.
inline void subtract_outer(double* __restrict c, const double* __restrict a, const double* __restrict b) {
  for (int r = 0; r < 6; ++r) {
    const double a0 = a[r];
    const double a1 = a[6 + r];
    const double a2 = a[12 + r];
    for (int k = 0; k < 6; ++k) c[6 * r + k] -= a0 * b[k] + a1 * b[6 + k] + a2 * b[12 + k];
  }
}

}  // namespace

Status BundleAdjuster::load(BundleProblem& problem, const BundleParams& params) {
  problem_ = nullptr;
  params_ = params;
  if (!(params.relative_tolerance >= 0) || !(params.robust_px >= 0) || !std::isfinite(params.robust_px) ||
      !(params.initial_damping > 0) || !std::isfinite(params.initial_damping) || !(params.observation_sigma_px > 0) ||
      !std::isfinite(params.observation_sigma_px) || params.loss > BundleLoss::cauchy) {
    return {StatusCode::invalid_argument, 4};
  }
  free_count_ = 0;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    if (!usable(problem.cameras[i])) return {StatusCode::invalid_argument, 1, static_cast<std::int64_t>(i)};
    cameras_[i].free_index = -1;
    if (!problem.cameras[i].fixed) {
      cameras_[i].free_index = static_cast<std::int32_t>(free_count_);
      camera_of_free_[free_count_++] = static_cast<std::uint16_t>(i);
    }
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (!all_finite(problem.points[i].position, 3)) {
      return {StatusCode::invalid_argument, 2, static_cast<std::int64_t>(i)};
    }
  }
  const auto count = static_cast<std::int32_t>(problem.cameras.size());
  const BundleScaleHold& hold = problem.hold;
  if (hold.origin >= count || hold.anchor >= count || (hold.origin < 0) != (hold.anchor < 0) ||
      (hold.origin >= 0 &&
       (free_count_ + 1 != problem.cameras.size() || !problem.cameras[static_cast<std::size_t>(hold.origin)].fixed ||
        hold.origin == hold.anchor))) {
    return {StatusCode::invalid_argument, 5};
  }
  ILP_TRY(check_priors(problem));
  problem_ = &problem;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) load_camera(i);
  const Status sorted = sort_observations();
  if (!sorted.ok()) {
    problem_ = nullptr;
    return sorted;
  }
  choose_active();
  return {};
}

void BundleAdjuster::load_camera(std::size_t index) {
  const BundleCamera& from = problem_->cameras[index];
  Camera& to = cameras_[index];
  const Mat3 rotation = rotation_from_quaternion(from.pose.q_cam_from_world);
  for (int i = 0; i < 9; ++i) to.rotation[i] = rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) to.centre[i] = from.pose.centre[i];
  to.fx = from.fx;
  to.fy = from.fy;
  to.cx = from.cx;
  to.cy = from.cy;
}

Status BundleAdjuster::sort_observations() {
  const std::size_t points = problem_->points.size();
  const std::size_t count = problem_->observations.size();
  for (std::size_t p = 0; p <= points; ++p) offsets_[p] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const BundleObservation& o = problem_->observations[i];
    if (o.camera >= problem_->cameras.size() || o.point >= points || !std::isfinite(o.x) || !std::isfinite(o.y)) {
      return {StatusCode::invalid_argument, 3, static_cast<std::int64_t>(i)};
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
        return {StatusCode::invalid_argument, 3, static_cast<std::int64_t>(p)};
      }
    }
    spans_[p] = {first, last, static_cast<std::uint16_t>(p)};
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
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      const Camera& camera = cameras_[observations_[i].camera];
      double depth = 0;
      for (int k = 0; k < 3; ++k) depth += camera.rotation[6 + k] * (x[k] - camera.centre[k]);
      if (depth > 0) observations_[kept++] = observations_[i];
    }
    if (kept - first < 2) {
      kept = first;
      continue;
    }
    spans_[kept_spans++] = {first, kept, span.point};
  }
  span_count_ = kept_spans;
  active_observations_ = kept;
}

void BundleAdjuster::accumulate_cost(const Camera& camera, const Observation& observation, const double point[3],
                                     Cost& cost) const {
  const double* r = camera.rotation;
  const double d0 = point[0] - camera.centre[0];
  const double d1 = point[1] - camera.centre[1];
  const double d2 = point[2] - camera.centre[2];
  const double z = r[6] * d0 + r[7] * d1 + r[8] * d2;
  if (!(z > 0)) {
    cost.valid = false;
    return;
  }
  const double inverse_z = 1 / z;
  const double eu = camera.fx * ((r[0] * d0 + r[1] * d1 + r[2] * d2) * inverse_z) + camera.cx - observation.x;
  const double ev = camera.fy * ((r[3] * d0 + r[4] * d1 + r[5] * d2) * inverse_z) + camera.cy - observation.y;
  const double squared = eu * eu + ev * ev;
  double weight = 1;
  cost.robust += loss()(squared, weight);
  cost.squared += squared;
}

BundleAdjuster::Cost BundleAdjuster::evaluate() const {
  Cost cost;
  for (std::size_t s = 0; s < span_count_; ++s) {
    const PointSpan& span = spans_[s];
    const double* x = problem_->points[span.point].position;
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      accumulate_cost(cameras_[observations_[i].camera], observations_[i], x, cost);
    }
  }
  cost.robust += prior_cost(cameras_);
  if (!std::isfinite(cost.robust)) cost.valid = false;
  return cost;
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
      return {StatusCode::invalid_argument, 5};
    }
  }
  return {};
}

Status BundleAdjuster::resume(BundleProblem& problem, const BundleParams& params, const BundleProgress& progress) {
  ILP_TRY(load(problem, params));
  progress_ = progress;
  return {};
}

bool BundleAdjuster::eliminate_point(const PointSpan& span, double damping, Eliminated& out) {
  const double* point = problem_->points[span.point].position;
  double v[6] = {0, 0, 0, 0, 0, 0};  // 00 01 02 11 12 22
  double g[3] = {0, 0, 0};
  for (std::uint32_t i = span.first; i < span.last; ++i) {
    const Observation& o = observations_[i];
    const Camera& camera = cameras_[o.camera];
    const bundle::Linearised at = bundle::linearise(camera, o, point, loss());
    const double* pu = at.pu;
    const double* pv = at.pv;
    const double pp[6] = {pu[0] * pu[0] + pv[0] * pv[0], pu[0] * pu[1] + pv[0] * pv[1], pu[0] * pu[2] + pv[0] * pv[2],
                          pu[1] * pu[1] + pv[1] * pv[1], pu[1] * pu[2] + pv[1] * pv[2], pu[2] * pu[2] + pv[2] * pv[2]};
    const double gp[3] = {pu[0] * at.eu + pv[0] * at.ev, pu[1] * at.eu + pv[1] * at.ev, pu[2] * at.eu + pv[2] * at.ev};
    for (int k = 0; k < 6; ++k) v[k] += pp[k];
    for (int k = 0; k < 3; ++k) g[k] += gp[k];
    if (camera.free_index < 0) continue;

    // The centre moves a projection as the point does, with the opposite sign: its rows of W are -pp.
    double* w = coupling_[i].data();
    CameraNormal& normal = normals_[static_cast<std::size_t>(camera.free_index)];
    for (int a = 0; a < 3; ++a) {
      for (int k = 0; k < 3; ++k) {
        const double cross = at.wu[a] * pu[k] + at.wv[a] * pv[k];
        w[6 * k + a] = cross;
        normal.hessian[6 * a + 3 + k] -= cross;
        if (k >= a) normal.hessian[6 * a + k] += at.wu[a] * at.wu[k] + at.wv[a] * at.wv[k];
      }
      normal.gradient[a] += at.wu[a] * at.eu + at.wv[a] * at.ev;
      normal.gradient[3 + a] -= gp[a];
    }
    constexpr int packed[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (int a = 0; a < 3; ++a) {
      for (int k = 0; k < 3; ++k) {
        w[6 * k + 3 + a] = -pp[packed[a][k]];
        if (k >= a) normal.hessian[6 * (3 + a) + 3 + k] += pp[packed[a][k]];
      }
    }
  }

  const double lambda[3] = {damping * damped_diagonal(v[0]), damping * damped_diagonal(v[3]),
                            damping * damped_diagonal(v[5])};
  const double p0 = v[0] + lambda[0];
  if (!(p0 > 0)) return false;
  const double i0 = 1 / std::sqrt(p0);
  const double l10 = v[1] * i0;
  const double l20 = v[2] * i0;
  const double p1 = v[3] + lambda[1] - l10 * l10;
  if (!(p1 > 0)) return false;
  const double i1 = 1 / std::sqrt(p1);
  const double l21 = (v[4] - l20 * l10) * i1;
  const double p2 = v[5] + lambda[2] - l20 * l20 - l21 * l21;
  if (!(p2 > 0) || !std::isfinite(p2)) return false;
  const double i2 = 1 / std::sqrt(p2);
  const double y0 = g[0] * i0;
  const double y1 = (g[1] - l10 * y0) * i1;
  const double y2 = (g[2] - l20 * y0 - l21 * y1) * i2;
  out = {{l10, l20, l21, i0, i1, i2}, {y0, y1, y2}, {g[0], g[1], g[2]}, {lambda[0], lambda[1], lambda[2]}};

  for (std::uint32_t i = span.first; i < span.last; ++i) {
    const std::int32_t a = cameras_[observations_[i].camera].free_index;
    if (a < 0) continue;
    const auto row = static_cast<std::size_t>(a);
    double* t = coupling_[i].data();
    double* reduced = &reduced_gradient_[camera_size * row];
    for (int k = 0; k < 6; ++k) {
      t[k] *= i0;
      t[6 + k] = (t[6 + k] - t[k] * l10) * i1;
      t[12 + k] = (t[12 + k] - t[k] * l20 - t[6 + k] * l21) * i2;
      reduced[k] -= t[k] * y0 + t[6 + k] * y1 + t[12 + k] * y2;
    }
    // Cameras ascend inside a point: the partners seen so far make the blocks above the diagonal.
    for (std::uint32_t j = span.first; j <= i; ++j) {
      const std::int32_t b = cameras_[observations_[j].camera].free_index;
      if (b < 0) continue;
      subtract_outer(blocks_[static_cast<std::size_t>(b) * max_cameras + row].data(), coupling_[j].data(), t);
    }
  }
  return true;
}

bool BundleAdjuster::linearise(double damping) {
  for (std::size_t a = 0; a < free_count_; ++a) {
    normals_[a] = {};
    for (std::size_t b = a; b < free_count_; ++b) blocks_[a * max_cameras + b].fill(0);
  }
  for (std::size_t k = 0; k < camera_size * free_count_; ++k) reduced_gradient_[k] = 0;
  for (std::size_t s = 0; s < span_count_; ++s) {
    if (!eliminate_point(spans_[s], damping, eliminated_[s])) return false;
  }
  add_priors();
  return true;
}

void BundleAdjuster::assemble(double damping) {
  const std::size_t n = camera_size * free_count_;
  for (std::size_t a = 0; a < free_count_; ++a) {
    for (std::size_t b = a; b < free_count_; ++b) {
      const double* block = blocks_[a * max_cameras + b].data();
      for (std::size_t r = 0; r < camera_size; ++r) {
        for (std::size_t c = 0; c < camera_size; ++c) {
          if (a == b && c < r) continue;
          double value = block[camera_size * r + c];
          if (a == b) {
            const double own = normals_[a].hessian[camera_size * r + c];
            value += own + (r == c ? damping * damped_diagonal(own) : 0);
          }
          system_[(camera_size * b + c) * n + camera_size * a + r] = value;
        }
      }
    }
    for (std::size_t r = 0; r < camera_size; ++r) reduced_gradient_[camera_size * a + r] += normals_[a].gradient[r];
  }
  if (problem_->hold.origin < 0) return;
  const HeldDistance held = held_distance();
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      system_[(camera_size * held.block + 3 + r) * n + camera_size * held.block + 3 + c] +=
          held.stiffness * held.direction[r] * held.direction[c];
    }
  }
}

BundleAdjuster::HeldDistance BundleAdjuster::held_distance() const {
  const Camera& origin = cameras_[static_cast<std::size_t>(problem_->hold.origin)];
  const Camera& anchor = cameras_[static_cast<std::size_t>(problem_->hold.anchor)];
  HeldDistance held;
  held.length = distance(origin.centre, anchor.centre);
  held.block = static_cast<std::size_t>(anchor.free_index);
  const double* h = normals_[held.block].hessian;
  held.stiffness = 1e6 * (h[21] + h[28] + h[35]);
  for (int k = 0; k < 3; ++k) held.direction[k] = (anchor.centre[k] - origin.centre[k]) / held.length;
  return held;
}

bool BundleAdjuster::solve_cameras(double& predicted_twice) {
  const std::size_t n = camera_size * free_count_;
  if (!cholesky_factor(system_.data(), n)) return false;
  for (std::size_t k = 0; k < n; ++k) camera_step_[k] = -reduced_gradient_[k];
  cholesky_solve(system_.data(), n, camera_step_.data());
  for (std::size_t a = 0; a < free_count_; ++a) {
    for (std::size_t r = 0; r < camera_size; ++r) {
      const double step = camera_step_[camera_size * a + r];
      const double diagonal = damped_diagonal(normals_[a].hessian[camera_size * r + r]);
      predicted_twice += step * (progress_.damping * diagonal * step - normals_[a].gradient[r]);
    }
  }
  return true;
}

BundleAdjuster::Cost BundleAdjuster::try_step(double& predicted_twice) {
  for (std::size_t a = 0; a < problem_->cameras.size(); ++a) trial_cameras_[a] = cameras_[a];
  for (std::size_t a = 0; a < free_count_; ++a) {
    Camera& camera = trial_cameras_[camera_of_free_[a]];
    const double* step = &camera_step_[camera_size * a];
    Mat3 rotation;
    for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = camera.rotation[i];
    // By way of the quaternion that the problem stores, so that a resumed adjustment starts from the same bits.
    double q[4];
    quaternion_from_rotation(rotation_from_vector(Vec3(step[0], step[1], step[2])) * rotation, q);
    rotation = rotation_from_quaternion(q);
    for (int i = 0; i < 4; ++i) trial_quaternions_[a][static_cast<std::size_t>(i)] = q[i];
    for (int i = 0; i < 9; ++i) camera.rotation[i] = rotation(i / 3, i % 3);
    for (int i = 0; i < 3; ++i) camera.centre[i] += step[3 + i];
  }
  Cost cost;
  for (std::size_t s = 0; s < span_count_; ++s) {
    const PointSpan& span = spans_[s];
    const Eliminated& e = eliminated_[s];
    double y0 = e.y[0];
    double y1 = e.y[1];
    double y2 = e.y[2];
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      const std::int32_t a = cameras_[observations_[i].camera].free_index;
      if (a < 0) continue;
      const double* t = coupling_[i].data();
      const double* step = &camera_step_[camera_size * static_cast<std::size_t>(a)];
      for (int k = 0; k < 6; ++k) {
        y0 += t[k] * step[k];
        y1 += t[6 + k] * step[k];
        y2 += t[12 + k] * step[k];
      }
    }
    double delta[3];
    delta[2] = -y2 * e.l[5];
    delta[1] = (-y1 - e.l[2] * delta[2]) * e.l[4];
    delta[0] = (-y0 - e.l[0] * delta[1] - e.l[1] * delta[2]) * e.l[3];
    const double* from = problem_->points[span.point].position;
    double* to = trial_points_[span.point].position;
    for (int k = 0; k < 3; ++k) {
      to[k] = from[k] + delta[k];
      predicted_twice += delta[k] * (e.damping[k] * delta[k] - e.gradient[k]);
    }
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      accumulate_cost(trial_cameras_[observations_[i].camera], observations_[i], to, cost);
    }
  }
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
      // A worse cost where hardly any gain was predicted is rounding: the minimum is reached.
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
  while (!progress_.done) ILP_TRY(step());
  return finish(result, joint);
}

}  // namespace ilp
