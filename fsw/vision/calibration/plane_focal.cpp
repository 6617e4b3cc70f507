#include "fsw/vision/calibration/plane_focal.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/solvers/homogeneous_system.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t min_matches = 30;
constexpr std::uint32_t min_pairs = 4;
constexpr int passes = 6;
constexpr int linearisations = 2;
// Relief moves neighbouring matches together: this many independent ones count.
constexpr double independent_matches = 4;
// The ground straight below a view is not the plane of its pair: the error of a height per residual.
constexpr double height_below_of_relief = 2;
// A view that is related to none.
constexpr double usual_relief = 0.01;
// Poorer attitudes are no beginning for a linearisation.
constexpr double max_tilt_sigma_rad = 0.035;
// What is not measured, in heights.
constexpr double unknown_place = 100, unknown_height = 0.3;
// The ground's height and slope about the mean plane, beyond what the pair's residuals show, and per residual.
constexpr double least_height_error = 0.003, height_error_of_relief = 1;
constexpr double least_slope_rad = 0.01, slope_of_relief = 5;
// Footprints of neighbouring pairs overlap, so that several pairs share an error of their ground.
constexpr double pairs_that_share = 4;

// Unknowns of a pair: the older view, its ground, the newer view, and what all views share.
enum Unknown : std::size_t { older = 0, ground = 6, newer = 9, shared = 15, unknowns = 18 };
// A view: rotation vector after the measured attitude, place / height. The ground: its height / height, two slopes. The
// shared ones: the principal point, the logarithm of the focal length.
using Vector = std::array<double, unknowns>;

constexpr std::size_t grid = 3;
constexpr double grid_step = 0.35;  // centred units: over the middle two thirds of the image
constexpr std::size_t residuals = 2 * grid * grid;
using Residuals = std::array<double, residuals>;

struct Information {
  std::array<Vector, unknowns> matrix{};
  Vector vector{};

  void add_prior(std::size_t k, double value, double sigma) {
    const double weight = 1 / (sigma * sigma);
    matrix[k][k] += weight;
    vector[k] += weight * value;
  }
  /// Marginalises over unknown k (Schur's complement).
  void eliminate(std::size_t k) {
    const double pivot = matrix[k][k];
    for (std::size_t i = 0; i < unknowns; ++i) {
      if (i == k || matrix[i][k] == 0) continue;
      const double factor = matrix[i][k] / pivot;
      vector[i] -= factor * vector[k];
      for (std::size_t j = 0; j < unknowns; ++j) {
        if (j != k) matrix[i][j] -= factor * matrix[k][j];
      }
    }
    for (std::size_t i = 0; i < unknowns; ++i) matrix[i][k] = matrix[k][i] = 0;
    vector[k] = 0;
  }
};

/// Means of all unknowns that have any information.
Vector means_of(Information information) {
  Vector out{};
  for (std::size_t k = 0; k < unknowns; ++k) {
    const double pivot = information.matrix[k][k];
    if (!(pivot > 0)) continue;
    for (std::size_t i = k + 1; i < unknowns; ++i) {
      const double factor = information.matrix[i][k] / pivot;
      for (std::size_t j = k; j < unknowns; ++j) information.matrix[i][j] -= factor * information.matrix[k][j];
      information.vector[i] -= factor * information.vector[k];
    }
  }
  for (std::size_t k = unknowns; k-- > 0;) {
    if (!(information.matrix[k][k] > 0)) continue;
    double sum = information.vector[k];
    for (std::size_t j = k + 1; j < unknowns; ++j) sum -= information.matrix[k][j] * out[j];
    out[k] = sum / information.matrix[k][k];
  }
  return out;
}

bool is_measured(const PlaneView& view) {
  return view.tilt_sigma_rad > 0 && view.tilt_sigma_rad < max_tilt_sigma_rad && view.heading_sigma_rad > 0;
}
bool has_height(const PlaneView& view) {
  return view.height_sigma_m > 0 && view.height_m > 0;
}

Vec2 mapped(const Mat3& h, double u, double v) {
  const Vec3 q = h * Vec3(u, v, 1);
  return {q.x() / q.z(), q.y() / q.z()};
}

Mat3 matrix_of(const double (&m)[9]) {
  Mat3 out;
  out << m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8];
  return out;
}

/// One pair with all that does not change while its unknowns are found.
struct Pair {
  const PlaneView& a;
  const PlaneView& b;
  double unit_m;  ///< of places and heights
  double log_focal;
  Mat3 measured;

  /// Differences between where the measured homography and the modelled one take the points of a grid.
  [[nodiscard]] Residuals differences(const Vector& x) const {
    const Mat3 level_a =
        rotation_from_vector({x[older], x[older + 1], x[older + 2]}) * rotation_from_quaternion(a.q_cam_from_level);
    const Mat3 level_b =
        rotation_from_vector({x[newer], x[newer + 1], x[newer + 2]}) * rotation_from_quaternion(b.q_cam_from_level);
    const Vec3 step(x[newer + 3] - x[older + 3], x[newer + 4] - x[older + 4], x[newer + 5] - x[older + 5]);
    const Vec3 normal(x[ground + 1], x[ground + 2], 1);
    const double height = x[older + 5] - x[ground];
    const Mat3 motion = level_b * (Mat3::Identity() + step * normal.transpose() / height) * level_a.transpose();
    const double f = det_exp(log_focal + x[shared + 2]);
    Mat3 k, inverse_k;
    k << f, 0, x[shared], 0, f, x[shared + 1], 0, 0, 1;
    inverse_k << 1 / f, 0, -x[shared] / f, 0, 1 / f, -x[shared + 1] / f, 0, 0, 1;
    const Mat3 modelled = k * motion * inverse_k;
    Residuals out;
    for (std::size_t i = 0; i < grid * grid; ++i) {
      const std::size_t row = i / grid, column = i % grid;
      const double u = grid_step * (static_cast<double>(column) - 1);
      const double v = grid_step * (static_cast<double>(row) - 1);
      const Vec2 difference = mapped(measured, u, v) - mapped(modelled, u, v);
      out[2 * i] = difference.x();
      out[2 * i + 1] = difference.y();
    }
    return out;
  }

  /// `information` with the pair, linearised about `at`.
  [[nodiscard]] Information with_differences(Information information, const Vector& at, double sigma) const {
    constexpr double step = 1e-6;
    const Residuals base = differences(at);
    std::array<Residuals, unknowns> slopes;
    for (std::size_t k = 0; k < unknowns; ++k) {
      Vector moved = at;
      moved[k] += step;
      slopes[k] = differences(moved);
      for (std::size_t r = 0; r < residuals; ++r) slopes[k][r] = (slopes[k][r] - base[r]) / step;
    }
    const double weight = 1 / (sigma * sigma);
    for (std::size_t r = 0; r < residuals; ++r) {
      double target = -base[r];
      for (std::size_t k = 0; k < unknowns; ++k) target += slopes[k][r] * at[k];
      for (std::size_t i = 0; i < unknowns; ++i) {
        information.vector[i] += weight * slopes[i][r] * target;
        for (std::size_t j = 0; j < unknowns; ++j) information.matrix[i][j] += weight * slopes[i][r] * slopes[j][r];
      }
    }
    return information;
  }
};

/// Deviations of the ground from its plane / height.
double relief_of(const PlanePair& pair) {
  return pair.motion > 0 ? pair.rms / pair.motion : usual_relief;
}

/// What the vehicle knows of a view. The rotation is about the camera's axes, the heading about the vertical one.
void add_view(const PlaneView& view, const Vec3& origin_m, double unit_m, std::size_t at, Information& information) {
  const Vec3 vertical = rotation_from_quaternion(view.q_cam_from_level).col(2);
  const double tilt = 1 / (view.tilt_sigma_rad * view.tilt_sigma_rad);
  const double heading = 1 / (view.heading_sigma_rad * view.heading_sigma_rad);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    information.matrix[at + i][at + i] += tilt;
    for (std::size_t j = 0; j < 3; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      information.matrix[at + i][at + j] += (heading - tilt) * vertical[row] * vertical[column];
    }
  }
  // Without a height there is no metre, and a place means nothing.
  const bool has_place = has_height(view) && view.horizontal_sigma_m > 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const double place_m = view.place_m[i] - origin_m[static_cast<Eigen::Index>(i)];
    information.add_prior(at + 3 + i, has_place ? place_m / unit_m : 0,
                          has_place ? view.horizontal_sigma_m / unit_m : unknown_place);
  }
  if (!has_height(view)) return information.add_prior(at + 5, 1, unknown_height);
  const double below_m = height_below_of_relief * relief_of(view.pair) * view.height_m;
  const double height_sigma_m = std::sqrt(view.height_sigma_m * view.height_sigma_m + below_m * below_m);
  information.add_prior(at + 5, view.height_m / unit_m, height_sigma_m / unit_m);
}

/// Makes the newer view the older one of the next pair.
void advance(Information& information) {
  for (std::size_t k = older; k < newer; ++k) information.eliminate(k);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      information.matrix[older + i][older + j] = information.matrix[newer + i][newer + j];
    }
    for (std::size_t j = shared; j < unknowns; ++j) {
      information.matrix[older + i][j] = information.matrix[j][older + i] = information.matrix[newer + i][j];
    }
    information.vector[older + i] = information.vector[newer + i];
  }
  for (std::size_t k = newer; k < shared; ++k) {
    for (std::size_t j = 0; j < unknowns; ++j) information.matrix[k][j] = information.matrix[j][k] = 0;
    information.vector[k] = 0;
  }
}

struct Estimate {
  double log_focal = 0, sigma = 0;
  std::uint32_t pairs = 0;
};

/// One pass of the filter.
Estimate go_along(std::span<const PlaneView> views, double log_focal, const PlaneFocalParams& params) {
  // Unknowns near one.
  double unit_m = 1;
  for (const PlaneView& view : views) unit_m = std::fmax(unit_m, view.height_m);
  Information information;
  information.add_prior(shared, 0, params.sigma_centre);
  information.add_prior(shared + 1, 0, params.sigma_centre);
  // Weak: it keeps a pass in range.
  information.add_prior(shared + 2, 0, 3);
  const Vec3 origin(views[0].place_m[0], views[0].place_m[1], views[0].place_m[2]);
  Estimate out;
  bool open = false;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PlaneView& view = views[i];
    const bool related = open && is_measured(view) && view.pair.matches >= min_matches;
    if (!related) {
      for (std::size_t k = older; k < ground; ++k) {
        if (open) information.eliminate(k);
      }
      open = is_measured(view);
      if (open) add_view(view, origin, unit_m, older, information);
      continue;
    }
    const double relief = relief_of(view.pair);
    const double share = std::sqrt(pairs_that_share);
    information.add_prior(ground, 0, share * (least_height_error + height_error_of_relief * relief));
    information.add_prior(ground + 1, 0, share * (least_slope_rad + slope_of_relief * relief));
    information.add_prior(ground + 2, 0, share * (least_slope_rad + slope_of_relief * relief));
    add_view(view, origin, unit_m, newer, information);
    const double noise = std::fmax(view.pair.rms, params.least_noise);
    const double count = std::fmin(independent_matches, view.pair.matches);
    const double sigma =
        std::sqrt(noise * noise * static_cast<double>(grid * grid) / count + params.least_noise * params.least_noise);
    const Pair pair{views[i - 1], view, unit_m, log_focal, matrix_of(view.pair.homography)};
    Information joint = information;
    for (int k = 0; k < linearisations; ++k) joint = pair.with_differences(information, means_of(joint), sigma);
    information = joint;
    advance(information);
    ++out.pairs;
  }
  for (std::size_t k = 0; k + 1 < unknowns; ++k) {
    if (information.matrix[k][k] > 0) information.eliminate(k);
  }
  const double weight = information.matrix[shared + 2][shared + 2];
  out.log_focal = log_focal + information.vector[shared + 2] / weight;
  out.sigma = 1 / std::sqrt(weight);
  return out;
}

bool converge(std::span<const PlaneView> views, double start, const PlaneFocalParams& params, Estimate& out) {
  const double low = det_log(params.min_focal);
  const double high = det_log(params.max_focal);
  double log_focal = std::clamp(det_log(start), low, high);
  double change = 0;
  for (int pass = 0; pass < passes; ++pass) {
    out = go_along(views, log_focal, params);
    // NaN compares false.
    if (!(out.sigma > 0) || !(std::fabs(out.log_focal) < 10)) return false;
    change = std::clamp(out.log_focal, low, high) - log_focal;
    log_focal += change;
    if (std::fabs(change) < 0.01 * out.sigma) break;
  }
  out.log_focal = log_focal;
  return std::fabs(change) < 0.1 * out.sigma && log_focal > low && log_focal < high;
}

}  // namespace

bool fit_plane_pair(const PointPairs& pairs, const InlierMask& inliers, const CentredFrame& frame, PlanePair& out) {
  constexpr int rounds = 3;
  constexpr double far = 3;
  const auto centred = [&](const PointPair& p) {
    return std::array<double, 4>{frame.u(p.xa), frame.v(p.ya), frame.u(p.xb), frame.v(p.yb)};
  };
  Mat3 plane = Mat3::Identity();
  double bound2 = 1e9;
  out = {};
  for (int round = 0; round < rounds; ++round) {
    HomogeneousSystem system;
    std::uint32_t used = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (inliers[i] == 0) continue;
      const auto [xa, ya, xb, yb] = centred(pairs[i]);
      if ((mapped(plane, xa, ya) - Vec2(xb, yb)).squaredNorm() > bound2) continue;
      system.add({xa, ya, 1, 0, 0, 0, -xb * xa, -xb * ya, -xb});
      system.add({0, 0, 0, xa, ya, 1, -yb * xa, -yb * ya, -yb});
      ++used;
    }
    if (used < min_matches || !system.solve(plane)) return false;
    double sum = 0;
    std::uint32_t inside = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (inliers[i] == 0) continue;
      const auto [xa, ya, xb, yb] = centred(pairs[i]);
      const double square = (mapped(plane, xa, ya) - Vec2(xb, yb)).squaredNorm();
      if (square > bound2) continue;
      sum += square;
      ++inside;
    }
    if (inside < min_matches) return false;
    // Half of it on each axis.
    out.rms = std::sqrt(0.5 * sum / inside);
    out.matches = inside;
    bound2 = 2 * far * far * out.rms * out.rms;
  }
  for (int i = 0; i < 9; ++i) out.homography[i] = plane(i / 3, i % 3);
  return plane.allFinite();
}

PlaneFocal find_plane_focal(std::span<const PlaneView> views, double start, const PlaneFocalParams& params) {
  PlaneFocal out;
  Estimate whole, first, second;
  if (views.size() <= 2 * std::size_t{min_pairs} || !converge(views, start, params, whole)) return out;
  out.pairs = whole.pairs;
  if (whole.pairs < 2 * min_pairs) return out;
  const std::size_t half = views.size() / 2;
  const double found = det_exp(whole.log_focal);
  if (!converge(views.first(half + 1), found, params, first) || !converge(views.subspan(half), found, params, second)) {
    return out;
  }
  const double spread = std::sqrt(first.sigma * first.sigma + second.sigma * second.sigma);
  out.consistency = std::fabs(first.log_focal - second.log_focal) / spread;
  out.focal = found;
  out.sigma = found * whole.sigma * std::fmax(1, out.consistency);
  out.found = true;
  return out;
}

}  // namespace ilp
