// Normal equations of the bundle adjustment: points are eliminated, two at a time, while their observations are read.
#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp {
namespace {

using bundle::both;
using bundle::Lanes;
using bundle::View;

constexpr std::size_t max_cameras = limits::max_bundle_cameras;
// Marquardt's scaling by the diagonal, kept away from zero so that an unseen direction still gets a damping.
constexpr double min_diagonal = 1e-6;

double damped_diagonal(double value) {
  return value < min_diagonal ? min_diagonal : value;
}
Lanes damped_diagonal(Lanes value) {
  return Lanes{damped_diagonal(value[0]), damped_diagonal(value[1])};
}

/// V + damping = L L^T; false if it is not positive definite. v: 00 01 02 11 12 22.
bool factor(const Lanes v[6], const Lanes damping[3], Lanes l[6]) {
  const Lanes p0 = v[0] + damping[0];
  l[3] = 1.0 / bundle::square_root(p0);
  l[0] = v[1] * l[3];
  l[1] = v[2] * l[3];
  const Lanes p1 = v[3] + damping[1] - l[0] * l[0];
  l[4] = 1.0 / bundle::square_root(p1);
  l[2] = (v[4] - l[1] * l[0]) * l[4];
  const Lanes p2 = v[5] + damping[2] - l[1] * l[1] - l[2] * l[2];
  l[5] = 1.0 / bundle::square_root(p2);
  return bundle::positive(p0) && bundle::positive(p1) && bundle::positive(p2) && std::isfinite(bundle::sum(p2));
}

/// x <- L^-1 x.
void forward(const Lanes l[6], Lanes x[3]) {
  x[0] = x[0] * l[3];
  x[1] = (x[1] - l[0] * x[0]) * l[4];
  x[2] = (x[2] - l[1] * x[0] - l[2] * x[1]) * l[5];
}

/// x <- L^-T x.
void backward(const Lanes l[6], Lanes x[3]) {
  x[2] = x[2] * l[5];
  x[1] = (x[1] - l[2] * x[2]) * l[4];
  x[0] = (x[0] - l[0] * x[1] - l[1] * x[2]) * l[3];
}

/// to = rotation^T from, or rotation from.
void turn(const double rotation[9], const double* from, bool transposed, double* to) {
  for (int r = 0; r < 3; ++r) {
    to[r] = 0;
    for (int k = 0; k < 3; ++k) to[r] += rotation[transposed ? 3 * k + r : 3 * r + k] * from[k];
  }
}

}  // namespace

void BundleAdjuster::pair_points() {
  std::sort(spans_.begin(), spans_.begin() + static_cast<std::ptrdiff_t>(span_count_),
            [](const PointSpan& a, const PointSpan& b) {
              return a.cameras != b.cameras ? a.cameras < b.cameras : a.point < b.point;
            });
  packet_count_ = 0;
  for (std::uint32_t s = 0; s < span_count_;) {
    const bool paired = s + 1 < span_count_ && spans_[s].cameras == spans_[s + 1].cameras;
    packets_[packet_count_++] = {s, paired ? s + 1 : s};
    s += paired ? 2 : 1;
  }
}

void BundleAdjuster::load_points(const Packet& packet, const BundlePoint* points, Lanes out[3]) const {
  const double* a = points[spans_[packet.a].point].position;
  const double* b = points[spans_[packet.b].point].position;
  for (int k = 0; k < 3; ++k) out[k] = Lanes{a[k], b[k]};
}

/// Observation k of both points.
inline void BundleAdjuster::load_observation(const Packet& packet, std::uint32_t k, Lanes& x, Lanes& y) const {
  const Observation& a = observations_[spans_[packet.a].first + k];
  const Observation& b = observations_[spans_[packet.b].first + k];
  x = Lanes{a.x, b.x};
  y = Lanes{a.y, b.y};
}

void BundleAdjuster::accumulate_cost(const Packet& packet, const std::array<Camera, max_cameras>& cameras,
                                     const Lanes point[3], Cost& cost) const {
  const PointSpan& span = spans_[packet.a];
  const int lanes = packet.a == packet.b ? 1 : 2;
  const bundle::Loss robust = loss();
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = cameras[observations_[span.first + k].camera];
    bundle::Projection p;
    if (!bundle::project(camera, point, p)) {
      cost.valid = false;
      return;
    }
    Lanes observed_x, observed_y;
    load_observation(packet, k, observed_x, observed_y);
    const Lanes eu = camera.fx * p.x + camera.cx - observed_x;
    const Lanes ev = camera.fy * p.y + camera.cy - observed_y;
    const Lanes squared = eu * eu + ev * ev;
    for (int lane = 0; lane < lanes; ++lane) {
      cost.squared += squared[lane];
      cost.robust += robust.cost(squared[lane]);
    }
  }
}

BundleAdjuster::Cost BundleAdjuster::evaluate() const {
  Cost cost;
  with_widest_vectors([&] {
    for (std::size_t p = 0; p < packet_count_; ++p) {
      Lanes point[3];
      load_points(packets_[p], problem_->points.data(), point);
      accumulate_cost(packets_[p], cameras_, point, cost);
    }
  });
  cost.robust += prior_cost(cameras_);
  if (!std::isfinite(cost.robust)) cost.valid = false;
  return cost;
}

bool BundleAdjuster::eliminate(const Packet& packet, double damping, Eliminated& out) {
  const PointSpan& span = spans_[packet.a];
  const Lanes counts = {1, packet.a == packet.b ? 0.0 : 1.0};
  const bundle::Loss robust = loss();
  Lanes point[3];
  load_points(packet, problem_->points.data(), point);
  std::array<View, max_cameras> views;
  std::array<std::size_t, max_cameras> free;
  std::size_t free_count = 0;
  Lanes v[6] = {};
  Lanes g[3] = {};
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = cameras_[observations_[span.first + k].camera];
    // A free camera's view is kept, a fixed one's is overwritten by the next.
    View& at = views[free_count];
    Lanes observed_x, observed_y;
    load_observation(packet, k, observed_x, observed_y);
    bundle::view(camera, observed_x, observed_y, point, robust, counts, at);
    for (std::size_t r = 0, i = 0; r < 3; ++r) {
      for (std::size_t c = r; c < 3; ++c, ++i) v[i] += at.pu[r] * at.pu[c] + at.pv[r] * at.pv[c];
      g[r] += at.pu[r] * at.eu + at.pv[r] * at.ev;
    }
    if (camera.free_index >= 0) free[free_count++] = static_cast<std::size_t>(camera.free_index);
  }
  out.damping[0] = damping * damped_diagonal(v[0]);
  out.damping[1] = damping * damped_diagonal(v[3]);
  out.damping[2] = damping * damped_diagonal(v[5]);
  if (!factor(v, out.damping, out.l)) return false;
  forward(out.l, g);
  for (int k = 0; k < 3; ++k) out.y[k] = g[k];
  for (std::size_t i = 0; i < free_count; ++i) {
    add_camera(views[i], out, normals_[free[i]], blocks_[free[i] * max_cameras + free[i]]);
    for (std::size_t j = 0; j < i; ++j) {
      const View& a = views[j];
      const View& b = views[i];
      Lanes n0[6], n1[6];
      // The points' derivatives have been multiplied by L^-1 by now.
      bundle::weigh(b, -(a.pu[0] * b.pu[0] + a.pu[1] * b.pu[1] + a.pu[2] * b.pu[2]),
                    -(a.pu[0] * b.pv[0] + a.pu[1] * b.pv[1] + a.pu[2] * b.pv[2]),
                    -(a.pv[0] * b.pu[0] + a.pv[1] * b.pu[1] + a.pv[2] * b.pu[2]),
                    -(a.pv[0] * b.pv[0] + a.pv[1] * b.pv[1] + a.pv[2] * b.pv[2]), n0, n1);
      bundle::add_block(a, n0, n1, blocks_[free[j] * max_cameras + free[i]].data());
    }
  }
  return true;
}

/// Turns the view's derivatives by the point into those of L^T times the point, and adds the camera's own block.
inline void BundleAdjuster::add_camera(View& at, const Eliminated& point, CameraNormal& normal,
                                       std::array<Lanes, 36>& block) {
  forward(point.l, at.pu);
  forward(point.l, at.pv);
  const Lanes ru = at.eu - (at.pu[0] * point.y[0] + at.pu[1] * point.y[1] + at.pu[2] * point.y[2]);
  const Lanes rv = at.ev - (at.pv[0] * point.y[0] + at.pv[1] * point.y[1] + at.pv[2] * point.y[2]);
  for (int k = 0; k < 3; ++k) {
    normal.gradient[k] += at.u[k] * ru + at.v[k] * rv;
    normal.turn[k] += at.u[k] * at.u[k] + at.v[k] * at.v[k];
  }
  normal.gradient[3] += at.u[3] * ru;
  normal.gradient[4] += at.v[4] * rv;
  normal.gradient[5] += at.u[5] * ru + at.v[5] * rv;
  normal.shift[0] += at.u[3] * at.u[3];
  normal.shift[1] += at.u[3] * at.u[5];
  normal.shift[2] += at.v[4] * at.v[4];
  normal.shift[3] += at.v[4] * at.v[5];
  normal.shift[4] += at.u[5] * at.u[5] + at.v[5] * at.v[5];
  const Lanes cross = -(at.pu[0] * at.pv[0] + at.pu[1] * at.pv[1] + at.pu[2] * at.pv[2]);
  Lanes n0[6], n1[6];
  bundle::weigh(at, 1.0 - (at.pu[0] * at.pu[0] + at.pu[1] * at.pu[1] + at.pu[2] * at.pu[2]), cross, cross,
                1.0 - (at.pv[0] * at.pv[0] + at.pv[1] * at.pv[1] + at.pv[2] * at.pv[2]), n0, n1);
  bundle::add_diagonal_block(at, n0, n1, block.data());
}

bool BundleAdjuster::linearise(double damping) {
  for (std::size_t a = 0; a < free_count_; ++a) {
    normals_[a] = {};
    for (std::size_t b = a; b < free_count_; ++b) blocks_[a * max_cameras + b].fill(both(0));
  }
  bool solvable = true;
  with_widest_vectors([&] {
    for (std::size_t p = 0; p < packet_count_ && solvable; ++p) {
      solvable = eliminate(packets_[p], damping, eliminated_[p]);
    }
  });
  if (!solvable) return false;
  for (std::size_t a = 0; a < free_count_; ++a) finish_normal(a);
  add_priors();
  return true;
}

/// Reduces the two lanes and turns gradient and diagonal from the camera's axes to the world's.
void BundleAdjuster::finish_normal(std::size_t a) {
  const CameraNormal& normal = normals_[a];
  const double* r = cameras_[camera_of_free_[a]].rotation;
  double own[3];
  for (std::size_t k = 0; k < 3; ++k) {
    reduced_gradient_[camera_size * a + k] = bundle::sum(normal.gradient[k]);
    diagonal_[camera_size * a + k] = bundle::sum(normal.turn[k]);
    own[k] = bundle::sum(normal.gradient[3 + k]);
  }
  turn(r, own, true, &reduced_gradient_[camera_size * a + 3]);
  const double h00 = bundle::sum(normal.shift[0]);
  const double h02 = bundle::sum(normal.shift[1]);
  const double h11 = bundle::sum(normal.shift[2]);
  const double h12 = bundle::sum(normal.shift[3]);
  const double h22 = bundle::sum(normal.shift[4]);
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = r[k];
    const double y = r[3 + k];
    const double z = r[6 + k];
    diagonal_[camera_size * a + 3 + k] = h00 * x * x + h11 * y * y + h22 * z * z + 2 * z * (h02 * x + h12 * y);
  }
}

/// Block (a, b) with the centres in the world's axes.
void BundleAdjuster::world_block(std::size_t a, std::size_t b, double out[36]) const {
  const std::array<Lanes, 36>& lanes = blocks_[a * max_cameras + b];
  double block[36];
  for (std::size_t r = 0; r < camera_size; ++r) {
    for (std::size_t c = 0; c < camera_size; ++c) {
      const std::size_t at = a == b && c < r ? camera_size * c + r : camera_size * r + c;
      block[camera_size * r + c] = bundle::sum(lanes[at]);
    }
  }
  const double* ra = cameras_[camera_of_free_[a]].rotation;
  const double* rb = cameras_[camera_of_free_[b]].rotation;
  for (std::size_t r = 0; r < camera_size; ++r) {
    double row[3];
    turn(rb, &block[camera_size * r + 3], true, row);
    for (std::size_t k = 0; k < 3; ++k) block[camera_size * r + 3 + k] = row[k];
  }
  for (std::size_t c = 0; c < camera_size; ++c) {
    const double column[3] = {block[18 + c], block[24 + c], block[30 + c]};
    double turned[3];
    turn(ra, column, true, turned);
    for (std::size_t r = 0; r < 3; ++r) {
      out[camera_size * r + c] = block[camera_size * r + c];
      out[camera_size * (r + 3) + c] = turned[r];
    }
  }
}

void BundleAdjuster::assemble(double damping) {
  const std::size_t n = camera_size * free_count_;
  const double prior_weight = params_.observation_sigma_px * params_.observation_sigma_px;
  for (std::size_t a = 0; a < free_count_; ++a) {
    for (std::size_t b = a; b < free_count_; ++b) {
      double block[36];
      world_block(a, b, block);
      for (std::size_t r = 0; r < camera_size; ++r) {
        for (std::size_t c = a == b ? r : 0; c < camera_size; ++c) {
          double value = block[camera_size * r + c];
          if (a == b) value += prior_weight * prior_blocks_[36 * a + camera_size * r + c];
          if (a == b && r == c) value += damping * damped_diagonal(diagonal_[camera_size * a + r]);
          system_[(camera_size * b + c) * n + camera_size * a + r] = value;
        }
      }
    }
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
  held.block = static_cast<std::size_t>(anchor.free_index);
  const double* h = &diagonal_[camera_size * held.block + 3];
  held.stiffness = 1e6 * (h[0] + h[1] + h[2]);
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    held.direction[k] = anchor.centre[k] - origin.centre[k];
    squared += held.direction[k] * held.direction[k];
  }
  held.length = std::sqrt(squared);
  for (double& d : held.direction) d /= held.length;
  return held;
}

/// Twice the gain that a full step d promises is d^T (D d - g) with damping D and gradient g. The points' part of -g^T
/// d is |y|^2, y = L^-1 g_point, once the cameras' is taken with the reduced gradient.
bool BundleAdjuster::solve_cameras(double& predicted_twice) {
  const std::size_t n = camera_size * free_count_;
  if (!cholesky_factor(system_.data(), n)) return false;
  for (std::size_t k = 0; k < n; ++k) camera_step_[k] = -reduced_gradient_[k];
  cholesky_solve(system_.data(), n, camera_step_.data());
  for (std::size_t k = 0; k < n; ++k) {
    const double step = camera_step_[k];
    predicted_twice += step * (progress_.damping * damped_diagonal(diagonal_[k]) * step - reduced_gradient_[k]);
  }
  for (std::size_t a = 0; a < free_count_; ++a) {
    const double* step = &camera_step_[camera_size * a];
    for (std::size_t k = 0; k < 3; ++k) own_step_[camera_size * a + k] = step[k];
    turn(cameras_[camera_of_free_[a]].rotation, step + 3, false, &own_step_[camera_size * a + 3]);
  }
  return true;
}

void BundleAdjuster::step_points(const Packet& packet, const Eliminated& e, Lanes from[3], double& predicted_twice) {
  const PointSpan& span = spans_[packet.a];
  const Lanes counts = {1, 1};
  const bundle::Loss robust = loss();
  Lanes h[3] = {};
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = cameras_[observations_[span.first + k].camera];
    if (camera.free_index < 0) continue;
    Lanes observed_x, observed_y;
    load_observation(packet, k, observed_x, observed_y);
    View at;
    bundle::view(camera, observed_x, observed_y, from, robust, counts, at);
    const double* step = &own_step_[camera_size * static_cast<std::size_t>(camera.free_index)];
    const Lanes du = at.u[0] * step[0] + at.u[1] * step[1] + at.u[2] * step[2] + at.u[3] * step[3] + at.u[5] * step[5];
    const Lanes dv = at.v[0] * step[0] + at.v[1] * step[1] + at.v[2] * step[2] + at.v[4] * step[4] + at.v[5] * step[5];
    for (int r = 0; r < 3; ++r) h[r] += at.pu[r] * du + at.pv[r] * dv;
  }
  forward(e.l, h);
  for (int k = 0; k < 3; ++k) h[k] = -(h[k] + e.y[k]);
  backward(e.l, h);
  Lanes gain = both(0);
  for (int k = 0; k < 3; ++k) {
    from[k] += h[k];
    gain += e.damping[k] * h[k] * h[k] + e.y[k] * e.y[k];
  }
  predicted_twice += packet.a == packet.b ? gain[0] : bundle::sum(gain);
  for (std::size_t k = 0; k < 3; ++k) {
    trial_points_[spans_[packet.b].point].position[k] = from[k][1];
    trial_points_[span.point].position[k] = from[k][0];
  }
}

BundleAdjuster::Cost BundleAdjuster::step_all_points(double& predicted_twice) {
  Cost cost;
  with_widest_vectors([&] {
    for (std::size_t p = 0; p < packet_count_; ++p) {
      Lanes point[3];
      load_points(packets_[p], problem_->points.data(), point);
      step_points(packets_[p], eliminated_[p], point, predicted_twice);
      accumulate_cost(packets_[p], trial_cameras_, point, cost);
    }
  });
  return cost;
}

}  // namespace ilp
