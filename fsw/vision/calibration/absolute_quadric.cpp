#include "fsw/vision/calibration/absolute_quadric.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/symmetric_solver.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/twoview/solvers/singular_values.hpp"

namespace ilp {
namespace {

using Vec5 = Eigen::Matrix<double, 5, 1>;
using Mat4 = Eigen::Matrix4d;
using RowMajor34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

Mat34 matrix_of(const ProjectiveCamera& camera) {
  return Eigen::Map<const RowMajor34>(camera.p);
}

/// Omega = [D, v; v^T, s].
Mat4 quadric_of(double f, const Vec3& v, double s) {
  Mat4 omega = Mat4::Zero();
  omega(0, 0) = omega(1, 1) = f * f;
  omega(2, 2) = 1;
  omega.block<3, 1>(0, 3) = v;
  omega.block<1, 3>(3, 0) = v.transpose();
  omega(3, 3) = s;
  return omega;
}

/// The five conditions on w = P Omega P^T, in sigmas but for the division by w_33.
Vec5 conditions(const Mat3& w, double f, const QuadricParams& params) {
  const double f2 = f * f;
  Vec5 out;
  out << (w(0, 0) - w(1, 1)) / (f2 * params.sigma_aspect),
      (0.5 * (w(0, 0) + w(1, 1)) / f2 - w(2, 2)) / params.sigma_focal, w(0, 1) / (f2 * params.sigma_skew),
      w(0, 2) / (f * params.sigma_centre), w(1, 2) / (f * params.sigma_centre);
  return out;
}

double enforced(double f, const Vec3& v) {
  return (v.x() * v.x() + v.y() * v.y()) / (f * f) + v.z() * v.z();
}

/// Mean squared condition of the rank-3 quadric; huge when a view's image of it is not positive.
double cost_of(const ProjectiveCameras& cameras, ViewSet views, const QuadricParams& params, double f, const Vec3& v) {
  const Mat4 omega = quadric_of(f, v, enforced(f, v));
  double sum = 0;
  double count = 0;
  for (std::size_t view = 1; view < limits::max_calibration_views; ++view) {
    if (!has_view(views, view)) continue;
    const Mat34 p = matrix_of(cameras[view]);
    const Mat3 w = p * omega * p.transpose();
    if (!(w(2, 2) > 1e-12)) return 1e12;
    sum += (conditions(w, f, params) / w(2, 2)).squaredNorm();
    count += 5;
  }
  return count > 0 ? sum / count : 1e12;
}

/// v and s of a given focal length by linear least squares, each view divided by its w_33 of the round before.
bool solve_plane(const ProjectiveCameras& cameras, ViewSet views, const QuadricParams& params, double f, Vec3& v) {
  std::array<double, limits::max_calibration_views> scale{};
  v.setZero();
  double s = 0;
  for (int round = 0; round < 5; ++round) {
    Mat4 normal = Mat4::Zero();
    Vec4 right = Vec4::Zero();
    for (std::size_t view = 1; view < limits::max_calibration_views; ++view) {
      if (!has_view(views, view)) continue;
      const Mat34 p = matrix_of(cameras[view]);
      const Mat3 w = p * quadric_of(f, v, s) * p.transpose();
      scale[view] = w(2, 2) > 1e-6 ? w(2, 2) : 1e-6 + std::fabs(w(2, 2));
      const Vec5 constant = conditions(p * quadric_of(f, Vec3::Zero(), 0) * p.transpose(), f, params) / scale[view];
      Eigen::Matrix<double, 5, 4> linear;
      for (int k = 0; k < 4; ++k) {
        Mat4 direction = Mat4::Zero();
        direction(k, 3) = direction(3, k) = 1;
        linear.col(k) = conditions(p * direction * p.transpose(), f, params) / scale[view];
      }
      normal += linear.transpose() * linear;
      right -= linear.transpose() * constant;
    }
    const Vec4 solution = solve_symmetric<4>(normal, right);
    if (!solution.allFinite()) return false;
    v = solution.head<3>();
    s = solution[3];
  }
  return true;
}

/// Gauss-Newton on v with s enforced, damped by halving.
double refine_plane(const ProjectiveCameras& cameras, ViewSet views, const QuadricParams& params, double f, Vec3& v) {
  double cost = cost_of(cameras, views, params, f, v);
  double damping = 1e-3;
  for (int step = 0; step < 15; ++step) {
    Mat3 normal = Mat3::Zero();
    Vec3 gradient = Vec3::Zero();
    for (std::size_t view = 1; view < limits::max_calibration_views; ++view) {
      if (!has_view(views, view)) continue;
      const Mat34 p = matrix_of(cameras[view]);
      const auto residual = [&](const Vec3& at) -> Vec5 {
        const Mat3 w = p * quadric_of(f, at, enforced(f, at)) * p.transpose();
        return conditions(w, f, params) / w(2, 2);
      };
      const Vec5 here = residual(v);
      Eigen::Matrix<double, 5, 3> jacobian;
      for (int k = 0; k < 3; ++k) {
        Vec3 moved = v;
        const double h = 1e-6 * (1 + std::fabs(v[k]));
        moved[k] += h;
        jacobian.col(k) = (residual(moved) - here) / h;
      }
      normal += jacobian.transpose() * jacobian;
      gradient += jacobian.transpose() * here;
    }
    normal.diagonal() *= 1 + damping;
    const Vec3 candidate = v - solve_symmetric<3>(normal, gradient);
    const double trial = candidate.allFinite() ? cost_of(cameras, views, params, f, candidate) : 1e12;
    if (trial < cost) {
      const bool converged = cost - trial < 1e-6 * cost;
      v = candidate;
      cost = trial;
      damping *= 0.1;
      if (converged) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  return cost;
}

double solve_for_focal(const ProjectiveCameras& cameras, ViewSet views, const QuadricParams& params, double f,
                       Vec3& v) {
  if (!solve_plane(cameras, views, params, f, v)) return 1e12;
  return refine_plane(cameras, views, params, f, v);
}

}  // namespace

bool find_absolute_quadric(const ProjectiveCameras& cameras, ViewSet views, const QuadricParams& params,
                           AbsoluteQuadric& quadric) {
  quadric = {};
  constexpr int steps = 32;
  const double low = det_log(params.min_focal);
  const double pace = (det_log(params.max_focal) - low) / steps;
  double best = 1e11;
  double at = 0;
  for (int i = 0; i <= steps; ++i) {
    Vec3 v;
    const double cost = solve_for_focal(cameras, views, params, det_exp(low + i * pace), v);
    if (!(cost < best)) continue;
    best = cost;
    at = low + i * pace;
  }
  if (!(best < 1e11)) return false;
  // Golden section between the neighbours on the grid.
  constexpr double golden = 0.6180339887498949;
  double a = at - pace;
  double b = at + pace;
  Vec3 v;
  for (int i = 0; i < 20; ++i) {
    const double left = b - golden * (b - a);
    const double right = a + golden * (b - a);
    const double cost_left = solve_for_focal(cameras, views, params, det_exp(left), v);
    const double cost_right = solve_for_focal(cameras, views, params, det_exp(right), v);
    if (cost_left < cost_right) {
      b = right;
    } else {
      a = left;
    }
  }
  quadric.focal = det_exp(0.5 * (a + b));
  quadric.cost = solve_for_focal(cameras, views, params, quadric.focal, v);
  if (!(quadric.cost < 1e11)) return false;
  const double f2 = quadric.focal * quadric.focal;
  quadric.plane[0] = -v.x() / f2;
  quadric.plane[1] = -v.y() / f2;
  quadric.plane[2] = -v.z();
  return true;
}

double upgrade_to_metric(const ProjectiveCameras& cameras, ViewSet views, const AbsoluteQuadric& quadric,
                         CalibrationTracks& tracks, double* scratch, MetricViews& metric) {
  const double f = quadric.focal;
  const Vec3 plane(quadric.plane[0], quadric.plane[1], quadric.plane[2]);
  metric = {};
  metric.focal = f;
  std::uint32_t known = 0;
  std::uint32_t positive = 0;
  for (CalibrationTrack& track : tracks) {
    if (!track.known) continue;
    track.point[2] += plane.dot(Vec3(track.point[0], track.point[1], 1));
    track.point[0] /= f;
    track.point[1] /= f;
    scratch[known++] = std::fabs(track.point[2]);
    positive += track.point[2] > 0 ? 1 : 0;
  }
  if (known == 0) return 0;
  std::nth_element(scratch, scratch + known / 2, scratch + known);
  const double middle = scratch[known / 2];
  if (!(middle > 0)) return 0;
  // The sign of w and of all translations is one choice; the scale of the world another.
  const double unit = 2 * positive >= known ? middle : -middle;
  for (std::size_t view = 1; view < limits::max_calibration_views; ++view) {
    if (!has_view(views, view)) continue;
    const Mat34 p = matrix_of(cameras[view]);
    const Vec3 k(1 / f, 1 / f, 1);
    Mat3 m = p.leftCols<3>() - p.col(3) * plane.transpose();
    m = (k.asDiagonal() * m).eval();
    m.col(0) *= f;
    m.col(1) *= f;
    const double scale = det_cbrt(m.determinant());
    SingularValues svd;
    if (!(std::fabs(scale) > 1e-9) || !singular_values(m / scale, svd)) return 0;
    const Mat3 rotation = svd.u * svd.v.transpose();
    const Vec3 translation = unit / scale * k.cwiseProduct(p.col(3));
    for (int i = 0; i < 9; ++i) metric.cameras[view].rotation[i] = rotation(i / 3, i % 3);
    for (int i = 0; i < 3; ++i) metric.cameras[view].translation[i] = translation[i];
  }
  std::uint32_t kept = 0;
  for (CalibrationTrack& track : tracks) {
    if (!track.known) continue;
    track.point[2] /= unit;
    for (std::size_t view = 0; view < limits::max_calibration_views && track.known; ++view) {
      if (!has_view(track.used & views, view)) continue;
      const MetricCamera& c = metric.cameras[view];
      const double z = c.rotation[6] * track.point[0] + c.rotation[7] * track.point[1] + c.rotation[8] +
                       track.point[2] * c.translation[2];
      track.known = track.point[2] > 0 && z > 0;
    }
    kept += track.known ? 1 : 0;
  }
  return static_cast<double>(kept) / known;
}

}  // namespace ilp
