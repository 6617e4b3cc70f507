#include "fsw/vision/twoview/homography.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/vision/twoview/levenberg_marquardt.hpp"
#include "fsw/vision/twoview/singular_values.hpp"
#include "fsw/vision/twoview/symmetric_eigen.hpp"

namespace ilp {
namespace {

double triangle(const Vec3& p, const Vec3& q, const Vec3& r) {
  return p.dot(q.cross(r));
}

/// The matrix that maps the projective frame (1,0,0), (0,1,0), (0,0,1), (1,1,1) to four points.
bool frame_to_points(const Vec3 (&p)[4], Mat3& m) {
  Mat3 columns;
  columns << p[0], p[1], p[2];
  const double det = triangle(p[0], p[1], p[2]);
  if (!(std::fabs(det) > 1e-8)) return false;
  const Vec3 weights(triangle(p[3], p[1], p[2]) / det, triangle(p[0], p[3], p[2]) / det,
                     triangle(p[0], p[1], p[3]) / det);
  m = columns * weights.asDiagonal();
  return weights.cwiseAbs().minCoeff() > 1e-8;
}

/// Transfer errors H x_a - x_b, with H's nine entries but the largest as parameters.
struct TransferProblem {
  struct State {
    Mat3 h;
    int fixed;  ///< index (row-major) of the entry that does not move
  };
  static constexpr int dof = 8;

  const NormalisedPairs& pairs;
  const PairSelection& selection;
  const RefinementParams& params;

  double weight_and_cost(double squared, double& cost) const {
    const double bound2 = params.bound_px * params.bound_px;
    const bool tukey = params.loss == RobustLoss::tukey;
    if (!(squared < bound2)) {
      cost += tukey ? bound2 / 3 : bound2;
      return 0;
    }
    const double rest = 1 - squared / bound2;
    cost += tukey ? bound2 / 3 * (1 - rest * rest * rest) : squared;
    return tukey ? rest * rest : 1;
  }

  void linearise(const State& state, NormalEquations<dof>& equations) const {
    equations = {};
    const Mat3& h = state.h;
    for (std::size_t i = 0; i < selection.count; ++i) {
      const NormalisedPair& p = pairs.exact[selection.indices[i]];
      const Vec3 y = h * p.ray_a();
      const double inverse = 1 / y.z();
      const double u = y.x() * inverse;
      const double v = y.y() * inverse;
      const double residual_u = (u - p.xb) * pairs.scale.bx;
      const double residual_v = (v - p.yb) * pairs.scale.by;
      const double weight = weight_and_cost(residual_u * residual_u + residual_v * residual_v, equations.cost);
      if (!(weight > 0)) continue;
      const double xa[3] = {p.xa * inverse, p.ya * inverse, inverse};
      double row_u[dof];
      double row_v[dof];
      for (int k = 0, e = 0; e < 9; ++e) {
        if (e == state.fixed) continue;
        const double x = xa[e % 3];
        row_u[k] = pairs.scale.bx * (e < 3 ? x : (e < 6 ? 0.0 : -u * x));
        row_v[k] = pairs.scale.by * (e < 3 ? 0.0 : (e < 6 ? x : -v * x));
        ++k;
      }
      for (int k = 0; k < dof; ++k) {
        equations.gradient[k] += weight * (row_u[k] * residual_u + row_v[k] * residual_v);
        for (int l = 0; l <= k; ++l) {
          equations.hessian(k, l) += weight * (row_u[k] * row_u[l] + row_v[k] * row_v[l]);
        }
      }
    }
    for (int k = 0; k < dof; ++k) {
      for (int l = 0; l < k; ++l) equations.hessian(l, k) = equations.hessian(k, l);
    }
  }

  double cost(const State& state) const {
    double sum = 0;
    for (std::size_t i = 0; i < selection.count; ++i) {
      weight_and_cost(transfer_squared(state.h, pairs.exact[selection.indices[i]], pairs.scale), sum);
    }
    return sum;
  }

  State moved(const State& state, const Eigen::Matrix<double, dof, 1>& step) const {
    State result = state;
    for (int k = 0, e = 0; e < 9; ++e) {
      if (e != state.fixed) result.h(e / 3, e % 3) += step[k++];
    }
    return result;
  }
};

}  // namespace

bool homography_from_four(const NormalisedPairs& pairs, const std::uint16_t sample[4], Mat3& homography) {
  Vec3 a[4];
  Vec3 b[4];
  for (int i = 0; i < 4; ++i) {
    a[i] = pairs.exact[sample[i]].ray_a();
    b[i] = pairs.exact[sample[i]].ray_b();
  }
  // Every triangle keeps its orientation when all points are in front of both cameras.
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    const int k = (i + 2) % 4;
    if (!(triangle(a[i], a[j], a[k]) * triangle(b[i], b[j], b[k]) > 0)) return false;
  }
  Mat3 frame_to_a;
  Mat3 frame_to_b;
  if (!frame_to_points(a, frame_to_a) || !frame_to_points(b, frame_to_b)) return false;
  homography = frame_to_b * frame_to_a.inverse();
  homography /= homography.norm();
  // Positive depths: H x_a is a positive multiple of x_b.
  if ((homography * a[0]).z() < 0) homography = -homography;
  return homography.allFinite();
}

bool fit_homography(const NormalisedPairs& pairs, const PairSelection& selection, Mat3& homography) {
  if (selection.count < 4) return false;
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  Matrix9 normal = Matrix9::Zero();
  for (std::size_t i = 0; i < selection.count; ++i) {
    const NormalisedPair& p = pairs.exact[selection.indices[i]];
    const double rows[2][9] = {{p.xa, p.ya, 1, 0, 0, 0, -p.xb * p.xa, -p.xb * p.ya, -p.xb},
                               {0, 0, 0, p.xa, p.ya, 1, -p.yb * p.xa, -p.yb * p.ya, -p.yb}};
    for (const double* row : {rows[0], rows[1]}) {
      for (int r = 0; r < 9; ++r) {
        for (int c = 0; c < 9; ++c) normal(r, c) += row[r] * row[c];
      }
    }
  }
  SymmetricEigen<9> eigen;
  if (!symmetric_eigen(normal, eigen)) return false;
  constexpr double ambiguous = 1e-13;
  if (!(eigen.values[1] > ambiguous * eigen.values[8])) return false;
  for (int i = 0; i < 9; ++i) homography(i / 3, i % 3) = eigen.vectors(i, 0);
  if ((homography * pairs.exact[selection.indices[0]].ray_a()).z() < 0) homography = -homography;
  return homography.allFinite();
}

bool refine_homography(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                       Mat3& homography) {
  if (selection.count < 4) return false;
  TransferProblem::State state{homography, 0};
  for (int e = 1; e < 9; ++e) {
    if (std::fabs(homography(e / 3, e % 3)) > std::fabs(homography(state.fixed / 3, state.fixed % 3))) state.fixed = e;
  }
  TransferProblem problem{pairs, selection, params};
  if (!levenberg_marquardt(problem, state, params.max_steps, params.min_gain)) return false;
  homography = state.h / state.h.norm();
  return true;
}

double transfer_squared(const Mat3& homography, const NormalisedPair& pair, const PixelScale& scale) {
  const Vec3 y = homography * pair.ray_a();
  if (!(y.z() > 0)) return std::numeric_limits<double>::infinity();
  const double du = (y.x() / y.z() - pair.xb) * scale.bx;
  const double dv = (y.y() / y.z() - pair.yb) * scale.by;
  return du * du + dv * dv;
}

double homography_sampson_squared(const Mat3& h, const NormalisedPair& p, const PixelScale& scale) {
  const Vec3 y = h * p.ray_a();
  if (!(y.z() > 0)) return std::numeric_limits<double>::infinity();
  // Two algebraic errors x_b w - u and y_b w - v, and their derivatives by the four coordinates in pixels.
  const double error[2] = {p.xb * y.z() - y.x(), p.yb * y.z() - y.y()};
  const double j[2][4] = {
      {(p.xb * h(2, 0) - h(0, 0)) / scale.ax, (p.xb * h(2, 1) - h(0, 1)) / scale.ay, y.z() / scale.bx, 0},
      {(p.yb * h(2, 0) - h(1, 0)) / scale.ax, (p.yb * h(2, 1) - h(1, 1)) / scale.ay, 0, y.z() / scale.by}};
  double c00 = 0;
  double c01 = 0;
  double c11 = 0;
  for (int k = 0; k < 4; ++k) {
    c00 += j[0][k] * j[0][k];
    c01 += j[0][k] * j[1][k];
    c11 += j[1][k] * j[1][k];
  }
  return (error[0] * error[0] * c11 - 2 * error[0] * error[1] * c01 + error[1] * error[1] * c00) /
         (c00 * c11 - c01 * c01);
}

bool score_homography(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px, const CostBound& bound,
                      RansacScore& score) {
  float h[9];
  for (int i = 0; i < 9; ++i) h[i] = static_cast<float>(homography(i / 3, i % 3));
  const auto scale_x = static_cast<float>(pairs.scale.bx);
  const auto scale_y = static_cast<float>(pairs.scale.by);
  const auto threshold2 = static_cast<float>(threshold_px * threshold_px);
  const BailOut given_up(bound, threshold_px * threshold_px, pairs.size());
  score = {};
  float squared[score_block];
  for (std::size_t first = 0; first < pairs.size(); first += score_block) {
    const std::size_t count = std::min(score_block, pairs.size() - first);
    const float* xa = pairs.xa + first;
    const float* ya = pairs.ya + first;
    const float* xb = pairs.xb + first;
    const float* yb = pairs.yb + first;
    for (std::size_t i = 0; i < count; ++i) {
      const float w = h[6] * xa[i] + h[7] * ya[i] + h[8];
      const float du = ((h[0] * xa[i] + h[1] * ya[i] + h[2]) / w - xb[i]) * scale_x;
      const float dv = ((h[3] * xa[i] + h[4] * ya[i] + h[5]) / w - yb[i]) * scale_y;
      const float distance2 = du * du + dv * dv;
      squared[i] = w > 0.0F ? distance2 : threshold2;
    }
    add_block(squared, count, threshold2, score);
    if (given_up(score.cost, first + count)) return false;
  }
  return true;
}

std::size_t decompose_homography(const Mat3& homography, PlaneMotion motions[4]) {
  SingularValues svd;
  if (!singular_values(homography, svd)) return 0;
  // Scaled to middle singular value 1 and positive determinant, H = R + t n^T / d.
  const double middle = svd.values[1];
  if (!(middle > 0) || svd.values[2] == 0) return 0;
  const Mat3 h = homography * ((svd.values[2] < 0 ? -1 : 1) / middle);
  const double s1 = svd.values[0] / middle;
  const double s3 = std::fabs(svd.values[2]) / middle;
  const double spread = s1 * s1 - s3 * s3;
  if (!(spread > 1e-12)) return 0;
  const double c1 = std::sqrt(std::fmax(0.0, 1 - s3 * s3) / spread);
  const double c3 = std::sqrt(std::fmax(0.0, s1 * s1 - 1) / spread);
  const Vec3 v1 = svd.v.col(0);
  const Vec3 v2 = svd.v.col(1);
  const Vec3 v3 = svd.v.col(2);
  for (std::size_t i = 0; i < 2; ++i) {
    // A direction in the plane through the origin that H maps without a change of lengths.
    const Vec3 u = c1 * v1 + (i == 0 ? c3 : -c3) * v3;
    Mat3 before;
    before << v2, u, v2.cross(u);
    Mat3 after;
    const Vec3 hv = h * v2;
    const Vec3 hu = h * u;
    after << hv, hu, hv.cross(hu);
    const Mat3 rotation = after * before.transpose();
    const Vec3 normal = v2.cross(u);
    const Vec3 t = (h - rotation) * normal;
    const double length = t.norm();
    if (!(length > 1e-9) || !rotation.allFinite()) return 0;
    motions[2 * i] = {{rotation, t / length}, length * normal};
    motions[2 * i + 1] = {{rotation, -t / length}, -length * normal};
  }
  return 4;
}

}  // namespace ilp
