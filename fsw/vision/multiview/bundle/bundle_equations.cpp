// Normal equations of the bundle adjustment: points are eliminated, two at a time, while their observations are read.
#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/multiview/bundle/bundle_equations.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp::bundle {
namespace {

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
  l[3] = 1.0 / square_root<V>(p0);
  l[0] = v[1] * l[3];
  l[1] = v[2] * l[3];
  const V p1 = v[3] + damping[1] - l[0] * l[0];
  l[4] = 1.0 / square_root<V>(p1);
  l[2] = (v[4] - l[1] * l[0]) * l[4];
  const V p2 = v[5] + damping[2] - l[1] * l[1] - l[2] * l[2];
  l[5] = 1.0 / square_root<V>(p2);
  bool finite = true;
  for (std::size_t lane = 0; lane < lanes_of<V>; lane += 2) finite &= std::isfinite(p2[lane] + p2[lane + 1]);
  return positive<V>(p0) && positive<V>(p1) && positive<V>(p2) && finite;
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

/// The factors of a packet, or of two side by side.
template <typename V>
struct Factors {
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
  void store_packet(Eliminated& to) {
    for (int k = 0; k < 6; ++k) to.l[k] = lanes_of_packet<Packet>(l[k]);
    for (int k = 0; k < 3; ++k) to.y[k] = lanes_of_packet<Packet>(y[k]);
    for (int k = 0; k < 3; ++k) to.damping[k] = lanes_of_packet<Packet>(damping[k]);
  }
  void store(Eliminated* to) {
    store_packet<0>(to[0]);
    if constexpr (packets_of<V> == 2) store_packet<1>(to[1]);
  }
};

/// Calls `work` with each packet, or with two neighbours of the same cameras where vectors are wide enough.
template <typename Work>
void for_each_packet(const Equations& eq, const Work& work) {
  with_known_vectors([&](auto width) {
    for (std::size_t p = 0; p < eq.packet_count;) {
      if constexpr (decltype(width)::is_wide) {
        if (p + 1 < eq.packet_count && eq.spans[eq.packets[p].a].cameras == eq.spans[eq.packets[p + 1].a].cameras) {
          work.template operator()<WideLanes>(p);
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
[[gnu::always_inline]] inline const PointSpan& span_of(const Equations& eq, std::size_t p, std::size_t lane) {
  const Packet& packet = eq.packets[p + lane / 2];
  return eq.spans[lane % 2 == 0 ? packet.a : packet.b];
}

template <typename V>
[[gnu::always_inline]] inline void load_points(const Equations& eq, std::size_t p, const BundlePoint* points,
                                               V (&out)[3]) {
  for (int k = 0; k < 3; ++k) {
    out[k] = gather<V>([&](std::size_t lane) { return points[span_of(eq, p, lane).point].position[k]; });
  }
}

/// Observation k of all points.
template <typename V>
[[gnu::always_inline]] inline void load_observation(const Equations& eq, std::size_t p, std::uint32_t k, V& x, V& y) {
  x = gather<V>([&](std::size_t lane) { return eq.observations[span_of(eq, p, lane).first + k].x; });
  y = gather<V>([&](std::size_t lane) { return eq.observations[span_of(eq, p, lane).first + k].y; });
}

/// Adds the lanes of all observations, one packet after the other. The cost is not valid where a point is not in front
/// of a camera.
template <typename V>
[[gnu::always_inline]] inline void accumulate_cost(const Equations& eq, std::size_t p, const Cameras& cameras,
                                                   const V (&point)[3], Cost& cost) {
  const PointSpan& span = span_of(eq, p, 0);
  const std::uint32_t count = span.last - span.first;
  const Loss robust = eq.loss();
  V squared[max_cameras], costs[max_cameras];
  bool in_front = true;
  for (std::uint32_t k = 0; k < count; ++k) {
    const Camera& camera = cameras[eq.observations[span.first + k].camera];
    Projection<V> at;
    project<V>(camera, point, at);
    in_front &= positive<V>(at.depth);
    V observed_x, observed_y;
    load_observation<V>(eq, p, k, observed_x, observed_y);
    const V eu = camera.fx * at.x + camera.cx - observed_x;
    const V ev = camera.fy * at.y + camera.cy - observed_y;
    squared[k] = eu * eu + ev * ev;
    costs[k] = robust_cost<V>(squared[k], robust);
  }
  if (!in_front) cost.valid = false;
  for (std::size_t i = 0; i < packets_of<V>; ++i) {
    const std::size_t lanes = eq.packets[p + i].a == eq.packets[p + i].b ? 1 : 2;
    for (std::uint32_t k = 0; k < count; ++k) {
      for (std::size_t lane = 2 * i; lane < 2 * i + lanes; ++lane) {
        cost.squared += squared[k][lane];
        cost.robust += costs[k][lane];
      }
    }
  }
}

template <typename V>
[[gnu::always_inline]] inline bool eliminate(Equations& eq, std::size_t p, double damping) {
  const PointSpan& span = span_of(eq, p, 0);
  const std::size_t last = p + packets_of<V> - 1;
  V counts = V{} + 1.0;
  if (eq.packets[last].a == eq.packets[last].b) counts[lanes_of<V> - 1] = 0;
  const Loss robust = eq.loss();
  V point[3];
  load_points<V>(eq, p, eq.problem->points.data(), point);
  std::array<View<V>, max_cameras> views;
  std::array<std::size_t, max_cameras> free;
  std::size_t free_count = 0;
  V v[6] = {};
  V g[3] = {};
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = eq.cameras[eq.observations[span.first + k].camera];
    // A free camera's view is kept, a fixed one's is overwritten by the next.
    View<V>& at = views[free_count];
    V observed_x, observed_y;
    load_observation<V>(eq, p, k, observed_x, observed_y);
    view<V>(camera, observed_x, observed_y, point, robust, counts, at);
    for (std::size_t r = 0, i = 0; r < 3; ++r) {
      for (std::size_t c = r; c < 3; ++c, ++i) v[i] += at.pu[r] * at.pu[c] + at.pv[r] * at.pv[c];
      g[r] += at.pu[r] * at.eu + at.pv[r] * at.ev;
    }
    if (camera.free) free[free_count++] = camera.block;
  }
  Factors<V> out;
  out.damping[0] = damping * damped_diagonals<V>(v[0]);
  out.damping[1] = damping * damped_diagonals<V>(v[3]);
  out.damping[2] = damping * damped_diagonals<V>(v[5]);
  if (!factor<V>(v, out.damping, out.l)) return false;
  forward<V>(out.l, g);
  for (int k = 0; k < 3; ++k) out.y[k] = g[k];
  out.store(&eq.eliminated[p]);
  for (std::size_t i = 0; i < free_count; ++i) {
    add_camera<V>(views[i], out, eq.normals[free[i]], eq.blocks[free[i] * max_cameras + free[i]]);
    for (std::size_t j = 0; j < i; ++j) {
      const View<V>& a = views[j];
      const View<V>& b = views[i];
      V n0[6], n1[6];
      // The points' derivatives have been multiplied by L^-1 by now.
      weigh<V>(b, -(a.pu[0] * b.pu[0] + a.pu[1] * b.pu[1] + a.pu[2] * b.pu[2]),
               -(a.pu[0] * b.pv[0] + a.pu[1] * b.pv[1] + a.pu[2] * b.pv[2]),
               -(a.pv[0] * b.pu[0] + a.pv[1] * b.pu[1] + a.pv[2] * b.pu[2]),
               -(a.pv[0] * b.pv[0] + a.pv[1] * b.pv[1] + a.pv[2] * b.pv[2]), n0, n1);
      add_block<false>(a, n0, n1, eq.blocks[free[j] * max_cameras + free[i]]);
    }
  }
  return true;
}

/// Turns the view's derivatives by the point into those of L^T times the point, and adds the camera's own block.
template <typename V>
[[gnu::always_inline]] inline void add_camera(View<V>& at, const Factors<V>& point, CameraNormal& normal,
                                              Block& block) {
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
  weigh<V>(at, 1.0 - (at.pu[0] * at.pu[0] + at.pu[1] * at.pu[1] + at.pu[2] * at.pu[2]), cross, cross,
           1.0 - (at.pv[0] * at.pv[0] + at.pv[1] * at.pv[1] + at.pv[2] * at.pv[2]), n0, n1);
  add_block<true>(at, n0, n1, block);
}

/// Reduces the two lanes and turns gradient and diagonal from the camera's axes to the world's.
void finish_normal(Equations& eq, std::size_t a) {
  const CameraNormal& normal = eq.normals[a];
  const double* r = eq.cameras[eq.camera_of_free[a]].rotation;
  double own[3];
  for (std::size_t k = 0; k < 3; ++k) {
    eq.reduced_gradient[camera_size * a + k] = sum(normal.gradient[k]);
    eq.diagonal[camera_size * a + k] = sum(normal.turn[k]);
    own[k] = sum(normal.gradient[3 + k]);
  }
  turn(r, own, true, &eq.reduced_gradient[camera_size * a + 3]);
  const double h00 = sum(normal.shift[0]);
  const double h02 = sum(normal.shift[1]);
  const double h11 = sum(normal.shift[2]);
  const double h12 = sum(normal.shift[3]);
  const double h22 = sum(normal.shift[4]);
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = r[k];
    const double y = r[3 + k];
    const double z = r[6 + k];
    eq.diagonal[camera_size * a + 3 + k] = h00 * x * x + h11 * y * y + h22 * z * z + 2 * z * (h02 * x + h12 * y);
  }
}

/// Block (a, b) with the centres in the world's axes.
void world_block(const Equations& eq, std::size_t a, std::size_t b, double out[36]) {
  const Block& lanes = eq.blocks[a * max_cameras + b];
  double block[36];
  for (std::size_t r = 0; r < camera_size; ++r) {
    for (std::size_t c = 0; c < camera_size; ++c) {
      block[camera_size * r + c] = sum(a == b && c < r ? lanes.at(c, r) : lanes.at(r, c));
    }
  }
  const double* ra = eq.cameras[eq.camera_of_free[a]].rotation;
  const double* rb = eq.cameras[eq.camera_of_free[b]].rotation;
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

template <typename V>
[[gnu::always_inline]] inline void step_points(Equations& eq, std::size_t p, V (&from)[3], double& predicted_twice) {
  const PointSpan& span = span_of(eq, p, 0);
  const V counts = V{} + 1.0;
  const Loss robust = eq.loss();
  Factors<V> e;
  e.load(&eq.eliminated[p]);
  V h[3] = {};
  for (std::uint32_t k = 0; k < span.last - span.first; ++k) {
    const Camera& camera = eq.cameras[eq.observations[span.first + k].camera];
    if (!camera.free) continue;
    V observed_x, observed_y;
    load_observation<V>(eq, p, k, observed_x, observed_y);
    View<V> at;
    view<V>(camera, observed_x, observed_y, from, robust, counts, at);
    const double* step = &eq.own_step[camera_size * camera.block];
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
    const Packet& packet = eq.packets[p + i];
    predicted_twice += packet.a == packet.b ? gain[2 * i] : gain[2 * i] + gain[2 * i + 1];
  }
  for (std::size_t lane = 0; lane < lanes_of<V>; ++lane) {
    for (int k = 0; k < 3; ++k) eq.trial_points[span_of(eq, p, lane).point].position[k] = from[k][lane];
  }
}

}  // namespace

void pair_points(Equations& eq) {
  std::sort(eq.spans.begin(), eq.spans.begin() + static_cast<std::ptrdiff_t>(eq.span_count),
            [](const PointSpan& a, const PointSpan& b) {
              return a.cameras != b.cameras ? a.cameras < b.cameras : a.point < b.point;
            });
  eq.packet_count = 0;
  for (std::uint32_t s = 0; s < eq.span_count;) {
    const bool paired = s + 1 < eq.span_count && eq.spans[s].cameras == eq.spans[s + 1].cameras;
    eq.packets[eq.packet_count++] = {s, paired ? s + 1 : s};
    s += paired ? 2 : 1;
  }
}

Cost evaluate(const Equations& eq) {
  Cost cost;
  for_each_packet(eq, [&]<typename V>(std::size_t p) {
    V point[3];
    load_points<V>(eq, p, eq.problem->points.data(), point);
    accumulate_cost<V>(eq, p, eq.cameras, point, cost);
  });
  if (!std::isfinite(cost.robust)) cost.valid = false;
  return cost;
}

bool linearise(Equations& eq, double damping) {
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    eq.normals[a] = {};
    for (std::size_t b = a; b < eq.free_count; ++b) eq.blocks[a * max_cameras + b] = {};
  }
  bool solvable = true;
  for_each_packet(eq, [&]<typename V>(std::size_t p) { solvable = solvable && eliminate<V>(eq, p, damping); });
  if (!solvable) return false;
  for (std::size_t a = 0; a < eq.free_count; ++a) finish_normal(eq, a);
  return true;
}

void assemble(Equations& eq, double damping) {
  const std::size_t n = camera_size * eq.free_count;
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    for (std::size_t b = a; b < eq.free_count; ++b) {
      double block[36];
      world_block(eq, a, b, block);
      for (std::size_t r = 0; r < camera_size; ++r) {
        for (std::size_t c = a == b ? r : 0; c < camera_size; ++c) {
          double value = block[camera_size * r + c];
          if (a == b && r == c) value += damping * damped_diagonal(eq.diagonal[camera_size * a + r]);
          eq.system[(camera_size * b + c) * n + camera_size * a + r] = value;
        }
      }
    }
  }
  if (!eq.problem->hold.held) return;
  const HeldDistance held = held_distance(eq);
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      eq.system[(camera_size * held.block + 3 + r) * n + camera_size * held.block + 3 + c] +=
          held.stiffness * held.direction[r] * held.direction[c];
    }
  }
}

HeldDistance held_distance(const Equations& eq) {
  const Camera& origin = eq.cameras[eq.problem->hold.origin];
  const Camera& anchor = eq.cameras[eq.problem->hold.anchor];
  HeldDistance held;
  held.block = anchor.block;
  const double* h = &eq.diagonal[camera_size * held.block + 3];
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
bool solve_cameras(Equations& eq, double damping, double& predicted_twice) {
  const std::size_t n = camera_size * eq.free_count;
  if (!cholesky_factor(eq.system.data(), n)) return false;
  for (std::size_t k = 0; k < n; ++k) eq.camera_step[k] = -eq.reduced_gradient[k];
  cholesky_solve(eq.system.data(), n, eq.camera_step.data());
  for (std::size_t k = 0; k < n; ++k) {
    const double step = eq.camera_step[k];
    predicted_twice += step * (damping * damped_diagonal(eq.diagonal[k]) * step - eq.reduced_gradient[k]);
  }
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    const double* step = &eq.camera_step[camera_size * a];
    for (std::size_t k = 0; k < 3; ++k) eq.own_step[camera_size * a + k] = step[k];
    turn(eq.cameras[eq.camera_of_free[a]].rotation, step + 3, false, &eq.own_step[camera_size * a + 3]);
  }
  return true;
}

Cost step_all_points(Equations& eq, double& predicted_twice) {
  Cost cost;
  for_each_packet(eq, [&]<typename V>(std::size_t p) {
    V point[3];
    load_points<V>(eq, p, eq.problem->points.data(), point);
    step_points<V>(eq, p, point, predicted_twice);
    accumulate_cost<V>(eq, p, eq.trial_cameras, point, cost);
  });
  return cost;
}

}  // namespace ilp::bundle
