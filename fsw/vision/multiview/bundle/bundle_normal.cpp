// Normal equations of the bundle adjustment: points are eliminated, two at a time, while their observations are read.
#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp {
namespace {

using bundle::lanes_of;
using bundle::packets_of;
using bundle::View;

constexpr std::size_t max_cameras = limits::max_bundle_cameras;
// Marquardt's scaling by the diagonal, kept away from zero so that an unseen direction still gets a damping.
constexpr double min_diagonal = 1e-6;

double damped_diagonal(double value) {
  return value < min_diagonal ? min_diagonal : value;
}
template <typename V>
[[gnu::always_inline]] inline V damped_diagonals(const V& value) {
  return value < min_diagonal ? V{} + min_diagonal : value;
}

/// V + damping = L L^T; false if it is not positive definite. v: 00 01 02 11 12 22.
template <typename V>
[[gnu::always_inline]] inline bool factor(const V (&v)[6], const V (&damping)[3], V (&l)[6]) {
  const V p0 = v[0] + damping[0];
  l[3] = 1.0 / bundle::square_root<V>(p0);
  l[0] = v[1] * l[3];
  l[1] = v[2] * l[3];
  const V p1 = v[3] + damping[1] - l[0] * l[0];
  l[4] = 1.0 / bundle::square_root<V>(p1);
  l[2] = (v[4] - l[1] * l[0]) * l[4];
  const V p2 = v[5] + damping[2] - l[1] * l[1] - l[2] * l[2];
  l[5] = 1.0 / bundle::square_root<V>(p2);
  bool finite = true;
  for (std::size_t lane = 0; lane < lanes_of<V>; lane += 2) finite &= std::isfinite(p2[lane] + p2[lane + 1]);
  return bundle::positive<V>(p0) && bundle::positive<V>(p1) && bundle::positive<V>(p2) && finite;
}

/// x <- L^-1 x.
template <typename V>
[[gnu::always_inline]] inline void forward(const V (&l)[6], V (&x)[3]) {
  x[0] = x[0] * l[3];
  x[1] = (x[1] - l[0] * x[0]) * l[4];
  x[2] = (x[2] - l[1] * x[0] - l[2] * x[1]) * l[5];
}

/// x <- L^-T x.
template <typename V>
[[gnu::always_inline]] inline void backward(const V (&l)[6], V (&x)[3]) {
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

/// The factors of a packet, or of two side by side.
template <typename V>
struct BundleAdjuster::Factors {
  V l[6], y[3], damping[3];

  void load(const Eliminated* from) {
    const auto join = [&](auto member) {
      if constexpr (packets_of<V> == 1) {
        return member(from[0]);
      } else {
        return __builtin_shufflevector(member(from[0]), member(from[1]), 0, 1, 2, 3);
      }
    };
    for (std::size_t k = 0; k < 6; ++k) l[k] = join([k](const Eliminated& e) { return e.l[k]; });
    for (std::size_t k = 0; k < 3; ++k) y[k] = join([k](const Eliminated& e) { return e.y[k]; });
    for (std::size_t k = 0; k < 3; ++k) damping[k] = join([k](const Eliminated& e) { return e.damping[k]; });
  }
  template <std::size_t Packet>
  void store_packet(Eliminated& to) const {
    for (int k = 0; k < 6; ++k) to.l[k] = bundle::lanes_of_packet<Packet>(l[k]);
    for (int k = 0; k < 3; ++k) to.y[k] = bundle::lanes_of_packet<Packet>(y[k]);
    for (int k = 0; k < 3; ++k) to.damping[k] = bundle::lanes_of_packet<Packet>(damping[k]);
  }
  void store(Eliminated* to) const {
    store_packet<0>(to[0]);
    if constexpr (packets_of<V> == 2) store_packet<1>(to[1]);
  }
};

/// Calls `work` with each packet, or with two neighbours of the same cameras where vectors are wide enough.
template <typename Work>
void BundleAdjuster::for_each_packet(const Work& work) const {
  with_known_vectors([&](auto width) {
    for (std::size_t p = 0; p < packet_count_;) {
      if constexpr (decltype(width)::is_wide) {
        if (p + 1 < packet_count_ && spans_[packets_[p].a].cameras == spans_[packets_[p + 1].a].cameras) {
          work.template operator()<bundle::WideLanes>(p);
          p += 2;
          continue;
        }
      }
      work.template operator()<Lanes>(p);
      ++p;
    }
  });
}

/// The span of a lane's point, counted from packet `p`.
[[gnu::always_inline]] inline const BundleAdjuster::PointSpan& BundleAdjuster::span_of(std::size_t p,
                                                                                       std::size_t lane) const {
  const Packet& packet = packets_[p + lane / 2];
  return spans_[lane % 2 == 0 ? packet.a : packet.b];
}

template <typename V>
[[gnu::always_inline]] inline void BundleAdjuster::load_points(std::size_t p, const BundlePoint* points,
                                                               V (&out)[3]) const {
  for (int k = 0; k < 3; ++k) {
    out[k] = bundle::gather<V>([&](std::size_t lane) { return points[span_of(p, lane).point].position[k]; });
  }
}

/// Observation k of all points.
template <typename V>
[[gnu::always_inline]] inline void BundleAdjuster::load_observation(std::size_t p, std::uint32_t k, V& x, V& y) const {
  x = bundle::gather<V>([&](std::size_t lane) { return observations_[span_of(p, lane).first + k].x; });
  y = bundle::gather<V>([&](std::size_t lane) { return observations_[span_of(p, lane).first + k].y; });
}

/// Adds the lanes of all observations, one packet after the other. The cost is not valid where a point is not in front
/// of a camera.
template <typename V>
[[gnu::always_inline]] inline void BundleAdjuster::accumulate_cost(std::size_t p,
                                                                   const std::array<Camera, max_cameras>& cameras,
                                                                   const V (&point)[3], Cost& cost) const {
  const PointSpan& span = span_of(p, 0);
  const std::uint32_t count = span.last - span.first;
  const bundle::Loss robust = loss();
  V squared[max_cameras], costs[max_cameras];
  bool in_front = true;
  for (std::uint32_t k = 0; k < count; ++k) {
    const Camera& camera = cameras[observations_[span.first + k].camera];
    bundle::Projection<V> at;
    bundle::project<V>(camera, point, at);
    in_front &= bundle::positive<V>(at.depth);
    V observed_x, observed_y;
    load_observation<V>(p, k, observed_x, observed_y);
    const V eu = camera.fx * at.x + camera.cx - observed_x;
    const V ev = camera.fy * at.y + camera.cy - observed_y;
    squared[k] = eu * eu + ev * ev;
    costs[k] = bundle::robust_cost<V>(squared[k], robust);
  }
  if (!in_front) cost.valid = false;
  for (std::size_t i = 0; i < packets_of<V>; ++i) {
    const std::size_t lanes = packets_[p + i].a == packets_[p + i].b ? 1 : 2;
    for (std::uint32_t k = 0; k < count; ++k) {
      for (std::size_t lane = 2 * i; lane < 2 * i + lanes; ++lane) {
        cost.squared += squared[k][lane];
        cost.robust += costs[k][lane];
      }
    }
  }
}

BundleAdjuster::Cost BundleAdjuster::evaluate() const {
  Cost cost;
  for_each_packet([&]<typename V>(std::size_t p) {
    V point[3];
    load_points<V>(p, problem_->points.data(), point);
    accumulate_cost<V>(p, cameras_, point, cost);
  });
  cost.robust += prior_cost(cameras_);
  if (!std::isfinite(cost.robust)) cost.valid = false;
  return cost;
}

template <typename V>
[[gnu::always_inline]] inline bool BundleAdjuster::eliminate(std::size_t p, double damping) {
  const PointSpan& span = span_of(p, 0);
  const std::size_t last = p + packets_of<V> - 1;
  V counts = V{} + 1.0;
  if (packets_[last].a == packets_[last].b) counts[lanes_of<V> - 1] = 0;
  const bundle::Loss robust = loss();
  V point[3];
  load_points<V>(p, problem_->points.data(), point);
  std::array<View<V>, max_cameras> views;
  std::array<std::size_t, max_cameras> free;
  std::size_t free_count = 0;
  V v[6] = {};
  V g[3] = {};
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = cameras_[observations_[span.first + k].camera];
    // A free camera's view is kept, a fixed one's is overwritten by the next.
    View<V>& at = views[free_count];
    V observed_x, observed_y;
    load_observation<V>(p, k, observed_x, observed_y);
    bundle::view<V>(camera, observed_x, observed_y, point, robust, counts, at);
    for (std::size_t r = 0, i = 0; r < 3; ++r) {
      for (std::size_t c = r; c < 3; ++c, ++i) v[i] += at.pu[r] * at.pu[c] + at.pv[r] * at.pv[c];
      g[r] += at.pu[r] * at.eu + at.pv[r] * at.ev;
    }
    if (camera.free_index >= 0) free[free_count++] = static_cast<std::size_t>(camera.free_index);
  }
  Factors<V> out;
  out.damping[0] = damping * damped_diagonals<V>(v[0]);
  out.damping[1] = damping * damped_diagonals<V>(v[3]);
  out.damping[2] = damping * damped_diagonals<V>(v[5]);
  if (!factor<V>(v, out.damping, out.l)) return false;
  forward<V>(out.l, g);
  for (int k = 0; k < 3; ++k) out.y[k] = g[k];
  out.store(&eliminated_[p]);
  for (std::size_t i = 0; i < free_count; ++i) {
    add_camera<V>(views[i], out, normals_[free[i]], blocks_[free[i] * max_cameras + free[i]]);
    for (std::size_t j = 0; j < i; ++j) {
      const View<V>& a = views[j];
      const View<V>& b = views[i];
      V n0[6], n1[6];
      // The points' derivatives have been multiplied by L^-1 by now.
      bundle::weigh<V>(b, -(a.pu[0] * b.pu[0] + a.pu[1] * b.pu[1] + a.pu[2] * b.pu[2]),
                       -(a.pu[0] * b.pv[0] + a.pu[1] * b.pv[1] + a.pu[2] * b.pv[2]),
                       -(a.pv[0] * b.pu[0] + a.pv[1] * b.pu[1] + a.pv[2] * b.pu[2]),
                       -(a.pv[0] * b.pv[0] + a.pv[1] * b.pv[1] + a.pv[2] * b.pv[2]), n0, n1);
      bundle::add_block<false>(a, n0, n1, blocks_[free[j] * max_cameras + free[i]]);
    }
  }
  return true;
}

/// Turns the view's derivatives by the point into those of L^T times the point, and adds the camera's own block.
template <typename V>
[[gnu::always_inline]] inline void BundleAdjuster::add_camera(View<V>& at, const Factors<V>& point,
                                                              CameraNormal& normal, bundle::Block& block) {
  using bundle::add_packets;
  forward<V>(point.l, at.pu);
  forward<V>(point.l, at.pv);
  const V ru = at.eu - (at.pu[0] * point.y[0] + at.pu[1] * point.y[1] + at.pu[2] * point.y[2]);
  const V rv = at.ev - (at.pv[0] * point.y[0] + at.pv[1] * point.y[1] + at.pv[2] * point.y[2]);
  for (int k = 0; k < 3; ++k) {
    add_packets<V>(normal.gradient[k], at.u[k] * ru + at.v[k] * rv);
    add_packets<V>(normal.turn[k], at.u[k] * at.u[k] + at.v[k] * at.v[k]);
  }
  add_packets<V>(normal.gradient[3], at.u[4] * ru);
  add_packets<V>(normal.gradient[4], at.v[5] * rv);
  add_packets<V>(normal.gradient[5], at.u[3] * ru + at.v[3] * rv);
  add_packets<V>(normal.shift[0], at.u[4] * at.u[4]);
  add_packets<V>(normal.shift[1], at.u[4] * at.u[3]);
  add_packets<V>(normal.shift[2], at.v[5] * at.v[5]);
  add_packets<V>(normal.shift[3], at.v[5] * at.v[3]);
  add_packets<V>(normal.shift[4], at.u[3] * at.u[3] + at.v[3] * at.v[3]);
  const V cross = -(at.pu[0] * at.pv[0] + at.pu[1] * at.pv[1] + at.pu[2] * at.pv[2]);
  V n0[6], n1[6];
  bundle::weigh<V>(at, 1.0 - (at.pu[0] * at.pu[0] + at.pu[1] * at.pu[1] + at.pu[2] * at.pu[2]), cross, cross,
                   1.0 - (at.pv[0] * at.pv[0] + at.pv[1] * at.pv[1] + at.pv[2] * at.pv[2]), n0, n1);
  bundle::add_block<true>(at, n0, n1, block);
}

bool BundleAdjuster::linearise(double damping) {
  for (std::size_t a = 0; a < free_count_; ++a) {
    normals_[a] = {};
    for (std::size_t b = a; b < free_count_; ++b) blocks_[a * max_cameras + b] = {};
  }
  bool solvable = true;
  for_each_packet([&]<typename V>(std::size_t p) { solvable = solvable && eliminate<V>(p, damping); });
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
  const bundle::Block& lanes = blocks_[a * max_cameras + b];
  double block[36];
  for (std::size_t r = 0; r < camera_size; ++r) {
    for (std::size_t c = 0; c < camera_size; ++c) {
      block[camera_size * r + c] = bundle::sum(a == b && c < r ? lanes.at(c, r) : lanes.at(r, c));
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

template <typename V>
[[gnu::always_inline]] inline void BundleAdjuster::step_points(std::size_t p, V (&from)[3], double& predicted_twice) {
  const PointSpan& span = span_of(p, 0);
  const V counts = V{} + 1.0;
  const bundle::Loss robust = loss();
  Factors<V> e;
  e.load(&eliminated_[p]);
  V h[3] = {};
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = cameras_[observations_[span.first + k].camera];
    if (camera.free_index < 0) continue;
    V observed_x, observed_y;
    load_observation<V>(p, k, observed_x, observed_y);
    View<V> at;
    bundle::view<V>(camera, observed_x, observed_y, from, robust, counts, at);
    const double* step = &own_step_[camera_size * static_cast<std::size_t>(camera.free_index)];
    const V du = at.u[0] * step[0] + at.u[1] * step[1] + at.u[2] * step[2] + at.u[4] * step[3] + at.u[3] * step[5];
    const V dv = at.v[0] * step[0] + at.v[1] * step[1] + at.v[2] * step[2] + at.v[5] * step[4] + at.v[3] * step[5];
    for (int r = 0; r < 3; ++r) h[r] += at.pu[r] * du + at.pv[r] * dv;
  }
  forward<V>(e.l, h);
  for (int k = 0; k < 3; ++k) h[k] = -(h[k] + e.y[k]);
  backward<V>(e.l, h);
  V gain = {};
  for (int k = 0; k < 3; ++k) {
    from[k] += h[k];
    gain += e.damping[k] * h[k] * h[k] + e.y[k] * e.y[k];
  }
  for (std::size_t i = 0; i < packets_of<V>; ++i) {
    const Packet& packet = packets_[p + i];
    predicted_twice += packet.a == packet.b ? gain[2 * i] : gain[2 * i] + gain[2 * i + 1];
  }
  for (std::size_t lane = 0; lane < lanes_of<V>; ++lane) {
    for (int k = 0; k < 3; ++k) trial_points_[span_of(p, lane).point].position[k] = from[k][lane];
  }
}

BundleAdjuster::Cost BundleAdjuster::step_all_points(double& predicted_twice) {
  Cost cost;
  for_each_packet([&]<typename V>(std::size_t p) {
    V point[3];
    load_points<V>(p, problem_->points.data(), point);
    step_points<V>(p, point, predicted_twice);
    accumulate_cost<V>(p, trial_cameras_, point, cost);
  });
  return cost;
}

}  // namespace ilp
