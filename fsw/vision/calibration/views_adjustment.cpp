#include "fsw/vision/calibration/views_adjustment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp {
namespace {

constexpr auto no_row = static_cast<std::size_t>(-1);  ///< of a camera that is fixed

/// Residual of one observation and its derivatives.
struct Linearised {
  double residual[2];
  double point[2][3];
  double camera[2][max_camera_unknowns];
  double shared[2][shared_unknowns];
};

/// Derivatives of (u, v) by q, and the residual.
struct Quotient {
  double inverse, u, v;
};

bool divide(const double q[3], Quotient& out) {
  if (!(std::fabs(q[2]) > 1e-12)) return false;
  out.inverse = 1 / q[2];
  out.u = q[0] * out.inverse;
  out.v = q[1] * out.inverse;
  return std::isfinite(out.u) && std::isfinite(out.v);
}

struct ProjectiveModel {
  static constexpr std::size_t camera_unknowns = 12;
  static constexpr std::size_t shared = 0;
  using State = ProjectiveCameras;

  static ProjectiveCamera projection(const State& cameras, std::size_t view) { return cameras[view]; }

  static bool linearise(const State& cameras, std::size_t view, const CalibrationTrack& track, Linearised& out) {
    const double* p = cameras[view].p;
    const double x[4] = {track.point[0], track.point[1], 1, track.point[2]};
    double q[3];
    for (std::size_t r = 0; r < 3; ++r)
      q[r] = p[4 * r] * x[0] + p[4 * r + 1] * x[1] + p[4 * r + 2] + p[4 * r + 3] * x[3];
    Quotient d;
    if (!divide(q, d)) return false;
    out.residual[0] = d.u - track.u[view];
    out.residual[1] = d.v - track.v[view];
    constexpr int column[3] = {0, 1, 3};
    for (int k = 0; k < 3; ++k) {
      out.point[0][k] = d.inverse * (p[column[k]] - d.u * p[8 + column[k]]);
      out.point[1][k] = d.inverse * (p[4 + column[k]] - d.v * p[8 + column[k]]);
    }
    for (int k = 0; k < 4; ++k) {
      out.camera[0][k] = out.camera[1][4 + k] = d.inverse * x[k];
      out.camera[0][4 + k] = out.camera[1][k] = 0;
      out.camera[0][8 + k] = -d.u * d.inverse * x[k];
      out.camera[1][8 + k] = -d.v * d.inverse * x[k];
    }
    return true;
  }

  static State moved(const State& cameras, const AdjustmentParams& params, const double* step) {
    State out = cameras;
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (!has_view(params.views, view) || view == params.fixed_view) continue;
      double norm2 = 0;
      for (double& entry : out[view].p) {
        entry += *step++;
        norm2 += entry * entry;
      }
      const double scale = std::sqrt(3 / norm2);
      for (double& entry : out[view].p) entry *= scale;
    }
    return out;
  }
};

struct MetricModel {
  static constexpr std::size_t camera_unknowns = 6;  // rotation vector from the left, translation
  static constexpr std::size_t shared = shared_unknowns;
  using State = MetricViews;

  static ProjectiveCamera projection(const State& views, std::size_t view) { return projection_of(views, view); }

  static bool linearise(const State& views, std::size_t view, const CalibrationTrack& track, Linearised& out) {
    const MetricCamera& c = views.cameras[view];
    const double* r = c.rotation;
    double turned[3];
    double y[3];
    for (std::size_t k = 0; k < 3; ++k) {
      turned[k] = r[3 * k] * track.point[0] + r[3 * k + 1] * track.point[1] + r[3 * k + 2];
      y[k] = turned[k] + track.point[2] * c.translation[k];
    }
    Quotient d;
    if (!divide(y, d)) return false;
    out.residual[0] = views.focal * d.u + views.cx - track.u[view];
    out.residual[1] = views.focal * d.v + views.cy - track.v[view];
    const double scale = views.focal * d.inverse;
    const double du[3] = {scale, 0, -scale * d.u};
    const double dv[3] = {0, scale, -scale * d.v};
    // d y / d rotation = -[turned]x
    const double rotation[3][3] = {{0, turned[2], -turned[1]}, {-turned[2], 0, turned[0]}, {turned[1], -turned[0], 0}};
    for (int k = 0; k < 3; ++k) {
      out.camera[0][k] = du[0] * rotation[0][k] + du[2] * rotation[2][k];
      out.camera[1][k] = dv[1] * rotation[1][k] + dv[2] * rotation[2][k];
      out.camera[0][3 + k] = track.point[2] * du[k];
      out.camera[1][3 + k] = track.point[2] * dv[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double column[3] = {k < 2 ? r[k] : c.translation[0], k < 2 ? r[3 + k] : c.translation[1],
                                k < 2 ? r[6 + k] : c.translation[2]};
      out.point[0][k] = du[0] * column[0] + du[2] * column[2];
      out.point[1][k] = dv[1] * column[1] + dv[2] * column[2];
    }
    out.shared[0][0] = d.u;
    out.shared[1][0] = d.v;
    out.shared[0][1] = out.shared[1][2] = 1;
    out.shared[0][2] = out.shared[1][1] = 0;
    return true;
  }

  static State moved(const State& views, const AdjustmentParams& params, const double* step) {
    State out = views;
    out.focal += step[0];
    out.cx += step[1];
    out.cy += step[2];
    step += shared;
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (!has_view(params.views, view) || view == params.fixed_view) continue;
      MetricCamera& camera = out.cameras[view];
      const Mat3 turn = rotation_from_vector(Vec3(step[0], step[1], step[2]));
      const Mat3 rotation = turn * Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(camera.rotation);
      for (int i = 0; i < 9; ++i) camera.rotation[i] = rotation(i / 3, i % 3);
      for (int k = 0; k < 3; ++k) camera.translation[k] += step[3 + k];
      step += camera_unknowns;
    }
    return out;
  }
};

bool takes_part(const CalibrationTrack& track, const AdjustmentParams& params) {
  if (!track.known || view_count(track.used & params.views) < params.min_views) return false;
  return params.left_out < 0 || track_block(track) != params.left_out;
}

double huber_weight(double squared, double bound) {
  return bound > 0 && squared > bound * bound ? bound / std::sqrt(squared) : 1;
}

double huber_cost(double squared, double bound) {
  if (!(bound > 0) || squared <= bound * bound) return 0.5 * squared;
  return bound * (std::sqrt(squared) - 0.5 * bound);
}

/// The unknowns in their order: shared ones, then the cameras that move.
template <class Model>
struct Layout {
  std::size_t size = Model::shared;
  std::array<std::size_t, limits::max_calibration_views> of_view{};

  explicit Layout(const AdjustmentParams& params) {
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      of_view[view] = 0;
      if (!has_view(params.views, view) || view == params.fixed_view) continue;
      of_view[view] = size;
      size += Model::camera_unknowns;
    }
  }
};

/// Blocks of J^T J between a point and everything that its observations depend on: the shared unknowns, then those of
/// the cameras that move. Each of the point's three unknowns has a row of its own, so that neighbours are added
/// together.
template <class Model>
struct Coupling {
  static constexpr std::size_t max_rows = Model::shared + Model::camera_unknowns * limits::max_calibration_views;
  double w[3][max_rows];
  std::array<std::size_t, limits::max_calibration_views> row_of_camera;
  std::size_t cameras = 0;
};

double* row(AdjustmentWorkspace& workspace, std::size_t size, std::size_t i) {
  return workspace.system.data() + i * size;
}

/// out += weight * (a_0 b_0 + a_1 b_1) for a row of `count` unknowns b.
template <std::size_t count>
void add_products(double weight, double a0, double a1, const double* b0, const double* b1, double* out) {
  for (std::size_t k = 0; k < count; ++k) out[k] += weight * (a0 * b0[k] + a1 * b1[k]);
}

/// Adds one observation to the normal equations, the point's block and the coupling. Of the system only the lower
/// triangle counts; blocks on its diagonal are filled whole.
template <class Model>
void add_observation(const Linearised& d, double weight, std::size_t camera_row, std::size_t size,
                     AdjustmentWorkspace& ws, double (&v)[6], double (&g)[3], Coupling<Model>& coupling) {
  constexpr std::size_t shared = Model::shared;
  constexpr std::size_t unknowns = Model::camera_unknowns;
  for (std::size_t a = 0; a < shared; ++a) {
    const double a0 = d.shared[0][a];
    const double a1 = d.shared[1][a];
    add_products<shared>(weight, a0, a1, d.shared[0], d.shared[1], row(ws, size, a));
    ws.gradient[a] += weight * (a0 * d.residual[0] + a1 * d.residual[1]);
    for (std::size_t k = 0; k < 3; ++k) coupling.w[k][a] += weight * (a0 * d.point[0][k] + a1 * d.point[1][k]);
  }
  if (camera_row != no_row) {
    const std::size_t place = shared + unknowns * coupling.cameras;
    for (std::size_t a = 0; a < unknowns; ++a) {
      const double a0 = d.camera[0][a];
      const double a1 = d.camera[1][a];
      double* out = row(ws, size, camera_row + a);
      add_products<shared>(weight, a0, a1, d.shared[0], d.shared[1], out);
      add_products<unknowns>(weight, a0, a1, d.camera[0], d.camera[1], out + camera_row);
      ws.gradient[camera_row + a] += weight * (a0 * d.residual[0] + a1 * d.residual[1]);
      for (std::size_t k = 0; k < 3; ++k) coupling.w[k][place + a] = weight * (a0 * d.point[0][k] + a1 * d.point[1][k]);
    }
    coupling.row_of_camera[coupling.cameras++] = camera_row;
  }
  int at = 0;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b <= a; ++b) v[at++] += weight * (d.point[0][a] * d.point[0][b] + d.point[1][a] * d.point[1][b]);
    g[a] += weight * (d.point[0][a] * d.residual[0] + d.point[1][a] * d.residual[1]);
  }
}

bool invert_damped(const double (&v)[6], double damping, double (&inverse)[9]) {
  const double floor = 1e-12 * (v[0] + v[2] + v[5]) + 1e-300;
  Mat3 m;
  m << v[0] * (1 + damping) + floor, v[1], v[3], v[1], v[2] * (1 + damping) + floor, v[4], v[3], v[4],
      v[5] * (1 + damping) + floor;
  const Eigen::LLT<Mat3> factor(m);
  if (factor.info() != Eigen::Success) return false;
  const Mat3 solved = factor.solve(Mat3::Identity());
  for (int i = 0; i < 9; ++i) inverse[i] = solved(i / 3, i % 3);
  return solved.allFinite();
}

/// out -= y W^T for the `count` unknowns from `place` on.
template <std::size_t count, class Model>
void subtract_products(const double (&y)[3], const Coupling<Model>& coupling, std::size_t place, double* out) {
  const double* w0 = coupling.w[0] + place;
  const double* w1 = coupling.w[1] + place;
  const double* w2 = coupling.w[2] + place;
  for (std::size_t k = 0; k < count; ++k) out[k] -= y[0] * w0[k] + y[1] * w1[k] + y[2] * w2[k];
}

/// Subtracts the part that the point explains: S -= W V^-1 W^T, g -= W V^-1 g_p.
template <class Model>
void eliminate(const Coupling<Model>& coupling, const AdjustmentWorkspace::Eliminated& point, std::size_t size,
               AdjustmentWorkspace& ws) {
  constexpr std::size_t shared = Model::shared;
  constexpr std::size_t unknowns = Model::camera_unknowns;
  const auto of_row = [&](std::size_t place, std::size_t at, std::size_t cameras) {
    double y[3];
    for (std::size_t k = 0; k < 3; ++k) {
      y[k] = coupling.w[0][place] * point.inverse[k] + coupling.w[1][place] * point.inverse[3 + k] +
             coupling.w[2][place] * point.inverse[6 + k];
    }
    double* out = row(ws, size, at);
    subtract_products<shared>(y, coupling, 0, out);
    for (std::size_t c = 0; c < cameras; ++c) {
      subtract_products<unknowns>(y, coupling, shared + unknowns * c, out + coupling.row_of_camera[c]);
    }
    ws.gradient[at] -= y[0] * point.gradient[0] + y[1] * point.gradient[1] + y[2] * point.gradient[2];
  };
  for (std::size_t a = 0; a < shared; ++a) of_row(a, a, 0);
  for (std::size_t c = 0; c < coupling.cameras; ++c) {
    for (std::size_t a = 0; a < unknowns; ++a) {
      of_row(shared + unknowns * c + a, coupling.row_of_camera[c] + a, c + 1);
    }
  }
}

/// Visits the observations of a track in the order of the views. False when one cannot be projected.
template <class Model>
bool collect_track(const typename Model::State& state, const CalibrationTrack& track, const AdjustmentParams& params,
                   const Layout<Model>& layout, AdjustmentWorkspace& ws, double (&v)[6], double (&g)[3],
                   Coupling<Model>& coupling) {
  coupling.cameras = 0;
  for (double(&of_unknown)[Coupling<Model>::max_rows] : coupling.w) {
    for (std::size_t k = 0; k < Model::shared; ++k) of_unknown[k] = 0;
  }
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
    if (!has_view(track.used & params.views, view)) continue;
    Linearised d;
    if (!Model::linearise(state, view, track, d)) return false;
    const double squared = d.residual[0] * d.residual[0] + d.residual[1] * d.residual[1];
    const std::size_t camera_row = view == params.fixed_view ? no_row : layout.of_view[view];
    add_observation<Model>(d, huber_weight(squared, params.robust), camera_row, layout.size, ws, v, g, coupling);
  }
  return true;
}

template <class Model>
bool assemble(const CalibrationTracks& tracks, const typename Model::State& state, const AdjustmentParams& params,
              const Layout<Model>& layout, double damping, AdjustmentWorkspace& ws) {
  for (std::size_t i = 0; i < layout.size * layout.size; ++i) ws.system[i] = 0;
  for (std::size_t i = 0; i < layout.size; ++i) ws.gradient[i] = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!takes_part(tracks[i], params)) continue;
    AdjustmentWorkspace::Eliminated& point = ws.eliminated[i];
    double v[6] = {};
    for (double& value : point.gradient) value = 0;
    Coupling<Model> coupling;
    if (!collect_track<Model>(state, tracks[i], params, layout, ws, v, point.gradient, coupling)) return false;
    if (!invert_damped(v, damping, point.inverse)) return false;
    eliminate<Model>(coupling, point, layout.size, ws);
  }
  return true;
}

/// The camera furthest from the fixed one. Its distance is held, because nothing else determines the scale.
std::size_t furthest_view(const MetricViews& views, const AdjustmentParams& params, Vec3& direction) {
  const auto centre = [&](std::size_t view) {
    const MetricCamera& c = views.cameras[view];
    Vec3 out;
    for (int k = 0; k < 3; ++k) {
      out[k] = -(c.rotation[k] * c.translation[0] + c.rotation[3 + k] * c.translation[1] +
                 c.rotation[6 + k] * c.translation[2]);
    }
    return out;
  };
  const Vec3 origin = centre(params.fixed_view);
  std::size_t furthest = params.fixed_view;
  double longest = 0;
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
    if (!has_view(params.views, view) || view == params.fixed_view) continue;
    const Vec3 away = centre(view) - origin;
    if (!(away.norm() > longest)) continue;
    longest = away.norm();
    furthest = view;
    // t = -R C: a change of the distance is one of t along R (C - origin).
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(views.cameras[view].rotation);
    direction = rotation * away / longest;
  }
  return furthest;
}

void add_priors(const ProjectiveCameras& /*cameras*/, const AdjustmentParams& /*params*/,
                const Layout<ProjectiveModel>& /*layout*/, AdjustmentWorkspace& /*ws*/) {}

void add_priors(const MetricViews& views, const AdjustmentParams& params, const Layout<MetricModel>& layout,
                AdjustmentWorkspace& ws) {
  const double weight = params.centre_weight;
  row(ws, layout.size, 1)[1] += weight;
  row(ws, layout.size, 2)[2] += weight;
  ws.gradient[1] += weight * views.cx;
  ws.gradient[2] += weight * views.cy;
  Vec3 direction = Vec3::Zero();
  const std::size_t furthest = furthest_view(views, params, direction);
  if (furthest == params.fixed_view) return;
  const std::size_t first = layout.of_view[furthest] + 3;
  double strength = 0;
  for (std::size_t k = 0; k < 3; ++k) strength += row(ws, layout.size, first + k)[first + k];
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      row(ws, layout.size, first + a)[first + b] +=
          strength * direction[static_cast<int>(a)] * direction[static_cast<int>(b)];
    }
  }
}

double prior_cost(const ProjectiveCameras& /*cameras*/, const AdjustmentParams& /*params*/) {
  return 0;
}
double prior_cost(const MetricViews& views, const AdjustmentParams& params) {
  return 0.5 * params.centre_weight * (views.cx * views.cx + views.cy * views.cy);
}
bool plausible(const ProjectiveCameras& /*cameras*/) {
  return true;
}
bool plausible(const MetricViews& views) {
  return views.focal > 0.05 && views.focal < 50;
}

double squared_of(const double (&p)[12], double x, double y, double w, double u, double v) {
  const double q[3] = {p[0] * x + p[1] * y + p[2] + p[3] * w, p[4] * x + p[5] * y + p[6] + p[7] * w,
                       p[8] * x + p[9] * y + p[10] + p[11] * w};
  Quotient d;
  if (!divide(q, d)) return 1e12;
  return (d.u - u) * (d.u - u) + (d.v - v) * (d.v - v);
}

template <class Model>
double cost_of(const CalibrationTracks& tracks, const typename Model::State& state, const AdjustmentParams& params,
               const AdjustmentWorkspace* trial) {
  std::array<ProjectiveCamera, limits::max_calibration_views> cameras;
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view)
    cameras[view] = Model::projection(state, view);
  double cost = prior_cost(state, params);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const CalibrationTrack& track = tracks[i];
    if (!takes_part(track, params)) continue;
    const double* x = trial != nullptr ? trial->trial_points[i].data() : track.point;
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (!has_view(track.used & params.views, view)) continue;
      cost += huber_cost(squared_of(cameras[view].p, x[0], x[1], x[2], track.u[view], track.v[view]), params.robust);
    }
  }
  return cost;
}

/// Points that follow the cameras' step: V^-1 (-g_p - W^T step).
template <class Model>
bool move_points(const CalibrationTracks& tracks, const typename Model::State& state, const AdjustmentParams& params,
                 const Layout<Model>& layout, AdjustmentWorkspace& ws) {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const CalibrationTrack& track = tracks[i];
    if (!takes_part(track, params)) continue;
    double right[3] = {};
    for (int k = 0; k < 3; ++k) right[k] = -ws.eliminated[i].gradient[k];
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (!has_view(track.used & params.views, view)) continue;
      Linearised d;
      if (!Model::linearise(state, view, track, d)) return false;
      double change[2] = {0, 0};
      for (int c = 0; c < 2; ++c) {
        for (std::size_t k = 0; k < Model::shared; ++k) change[c] += d.shared[c][k] * ws.step[k];
        if (view == params.fixed_view) continue;
        for (std::size_t k = 0; k < Model::camera_unknowns; ++k) {
          change[c] += d.camera[c][k] * ws.step[layout.of_view[view] + k];
        }
      }
      const double squared = d.residual[0] * d.residual[0] + d.residual[1] * d.residual[1];
      const double weight = huber_weight(squared, params.robust);
      for (int k = 0; k < 3; ++k) right[k] -= weight * (d.point[0][k] * change[0] + d.point[1][k] * change[1]);
    }
    const double* inverse = ws.eliminated[i].inverse;
    for (std::size_t k = 0; k < 3; ++k) {
      ws.trial_points[i][k] =
          track.point[k] + inverse[3 * k] * right[0] + inverse[3 * k + 1] * right[1] + inverse[3 * k + 2] * right[2];
    }
  }
  return true;
}

template <class Model>
bool solve_step(const CalibrationTracks& tracks, const typename Model::State& state, const AdjustmentParams& params,
                const Layout<Model>& layout, double damping, AdjustmentWorkspace& ws) {
  if (!assemble<Model>(tracks, state, params, layout, damping, ws)) return false;
  double trace = 0;
  for (std::size_t i = 0; i < layout.size; ++i) trace += row(ws, layout.size, i)[i];
  add_priors(state, params, layout, ws);
  // A fraction of the trace for the frame of reference, which nothing constrains.
  const double floor = 1e-9 * trace / static_cast<double>(layout.size);
  for (std::size_t i = 0; i < layout.size; ++i) row(ws, layout.size, i)[i] *= 1 + damping;
  for (std::size_t i = 0; i < layout.size; ++i) row(ws, layout.size, i)[i] += damping * floor + 1e-6 * floor;
  if (!cholesky_factor(ws.system.data(), layout.size)) return false;
  for (std::size_t i = 0; i < layout.size; ++i) ws.step[i] = -ws.gradient[i];
  cholesky_solve(ws.system.data(), layout.size, ws.step.data());
  return move_points<Model>(tracks, state, params, layout, ws);
}

template <class Model>
void iterate(CalibrationTracks& tracks, typename Model::State& state, const AdjustmentParams& params,
             AdjustmentWorkspace& ws, AdjustmentProgress& progress) {
  constexpr double largest_damping = 1e8;
  if (progress.done) return;
  const Layout<Model> layout(params);
  if (progress.cost < 0) {
    progress.cost = cost_of<Model>(tracks, state, params, nullptr);
    return;
  }
  ++progress.iterations;
  progress.done = progress.iterations >= params.max_iterations;
  bool better = false;
  double cost = 0;
  typename Model::State trial = state;
  if (solve_step<Model>(tracks, state, params, layout, progress.damping, ws)) {
    trial = Model::moved(state, params, ws.step.data());
    if (plausible(trial)) {
      cost = cost_of<Model>(tracks, trial, params, &ws);
      better = cost < progress.cost;
    }
  }
  if (!better) {
    progress.damping *= 10;
    progress.done = progress.done || progress.damping > largest_damping;
    return;
  }
  // A small gain under heavy damping means a short step, not the minimum.
  const bool converged = progress.cost - cost <= params.relative_tolerance * progress.cost && progress.damping <= 1e-3;
  progress.done = progress.done || converged;
  progress.cost = cost;
  progress.damping = std::fmax(0.1 * progress.damping, 1e-9);
  state = trial;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!takes_part(tracks[i], params)) continue;
    for (std::size_t k = 0; k < 3; ++k) tracks[i].point[k] = ws.trial_points[i][k];
  }
}

}  // namespace

std::int32_t track_block(const CalibrationTrack& track) {
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
    if (!has_view(track.seen, view)) continue;
    // 4 x 2 blocks that are a quarter wide in centred units: an image is about 1.14 x 0.86.
    const double column = std::floor(4 * (track.u[view] + 0.5));
    const std::int32_t i = column < 0 ? 0 : column > 3 ? 3 : static_cast<std::int32_t>(column);
    return track.v[view] < 0 ? i : i + 4;
  }
  return 0;
}

void adjust_projective(CalibrationTracks& tracks, ProjectiveCameras& cameras, const AdjustmentParams& params,
                       AdjustmentWorkspace& workspace, AdjustmentProgress& progress) {
  iterate<ProjectiveModel>(tracks, cameras, params, workspace, progress);
}

void adjust_metric(CalibrationTracks& tracks, MetricViews& views, const AdjustmentParams& params,
                   AdjustmentWorkspace& workspace, AdjustmentProgress& progress) {
  iterate<MetricModel>(tracks, views, params, workspace, progress);
}

void metric_covariance(const CalibrationTracks& tracks, const MetricViews& views, const AdjustmentParams& params,
                       AdjustmentWorkspace& workspace, MetricCovariance& covariance) {
  covariance = {};
  AdjustmentParams plain = params;
  plain.robust = 0;
  const Layout<MetricModel> layout(plain);
  for (const CalibrationTrack& track : tracks) {
    if (!takes_part(track, plain)) continue;
    ++covariance.points;
    covariance.observations += view_count(track.used & plain.views);
  }
  const double unknowns = 3.0 * covariance.points + static_cast<double>(layout.size) - 1;
  const double freedom = 2.0 * covariance.observations - unknowns;
  if (!(freedom > 0)) return;
  AdjustmentParams without_prior = plain;
  without_prior.centre_weight = 0;
  covariance.noise = std::sqrt(2 * cost_of<MetricModel>(tracks, views, without_prior, nullptr) / freedom);
  if (!assemble<MetricModel>(tracks, views, plain, layout, 0, workspace)) return;
  add_priors(views, plain, layout, workspace);
  if (!cholesky_factor(workspace.system.data(), layout.size)) return;
  double variance[shared_unknowns];
  for (std::size_t k = 0; k < shared_unknowns; ++k) {
    for (std::size_t i = 0; i < layout.size; ++i) workspace.step[i] = i == k ? 1 : 0;
    cholesky_solve(workspace.system.data(), layout.size, workspace.step.data());
    variance[k] = workspace.step[k];
    if (!(variance[k] > 0) || !std::isfinite(variance[k])) return;
  }
  covariance.sigma_focal = covariance.noise * std::sqrt(variance[0]);
  covariance.sigma_cx = covariance.noise * std::sqrt(variance[1]);
  covariance.sigma_cy = covariance.noise * std::sqrt(variance[2]);
  covariance.valid = true;
}

double squared_residual(const double (&p)[12], const CalibrationTrack& track, std::size_t view) {
  return squared_of(p, track.point[0], track.point[1], track.point[2], track.u[view], track.v[view]);
}

ProjectiveCamera projection_of(const MetricViews& views, std::size_t view) {
  const MetricCamera& c = views.cameras[view];
  ProjectiveCamera out;
  for (int column = 0; column < 4; ++column) {
    const double y[3] = {column < 3 ? c.rotation[column] : c.translation[0],
                         column < 3 ? c.rotation[3 + column] : c.translation[1],
                         column < 3 ? c.rotation[6 + column] : c.translation[2]};
    out.p[column] = views.focal * y[0] + views.cx * y[2];
    out.p[4 + column] = views.focal * y[1] + views.cy * y[2];
    out.p[8 + column] = y[2];
  }
  return out;
}

bool triangulate_linear(const ProjectiveCameras& cameras, ViewSet posed, CalibrationTrack& track) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
    if (!has_view(track.used & posed, view)) continue;
    const double* p = cameras[view].p;
    const double observed[2] = {track.u[view], track.v[view]};
    for (std::size_t c = 0; c < 2; ++c) {
      const double* a = p + 4 * c;
      const double* b = p + 8;
      const double s = observed[c];
      const Vec3 equation(a[0] - s * b[0], a[1] - s * b[1], a[3] - s * b[3]);
      normal += equation * equation.transpose();
      right -= equation * (a[2] - s * b[2]);
    }
  }
  const Eigen::LDLT<Mat3> factor(normal);
  const Vec3 x = factor.solve(right);
  if (factor.info() != Eigen::Success || !x.allFinite() || !(x.cwiseAbs().maxCoeff() < 1e6)) return false;
  for (int k = 0; k < 3; ++k) track.point[k] = x[k];
  return true;
}

}  // namespace ilp
