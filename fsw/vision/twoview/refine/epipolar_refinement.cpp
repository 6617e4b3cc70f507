#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/base/math.hpp"
#include "fsw/vision/twoview/refine/normal_equations.hpp"
#include "fsw/vision/twoview/solvers/decompose_essential.hpp"
#include "fsw/vision/twoview/solvers/singular_values.hpp"
#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"

namespace ilp {
namespace {

/// Two matches side by side in one register; operations go lane by lane, so that results do not depend on the machine.
using Lanes = double __attribute__((vector_size(16)));

struct TwoMatches {
  Lanes xa, ya, xb, yb;

  TwoMatches(const NormalisedPair& p, const NormalisedPair& q)
      : xa{p.xa, q.xa}, ya{p.ya, q.ya}, xb{p.xb, q.xb}, yb{p.yb, q.yb} {}
};

/// The epipolar lines of two matches, and what Sampson's distance makes of them.
struct EpipolarLines {
  Lanes b0, b1, a0, a1;  ///< normals, by the squares of the pixels' scales
  Lanes error, norm2;

  EpipolarLines(const Mat3& m, const TwoMatches& p, const PixelScale& scale) {
    const Lanes line_b0 = m(0, 0) * p.xa + m(0, 1) * p.ya + m(0, 2);
    const Lanes line_b1 = m(1, 0) * p.xa + m(1, 1) * p.ya + m(1, 2);
    const Lanes line_b2 = m(2, 0) * p.xa + m(2, 1) * p.ya + m(2, 2);
    const Lanes line_a0 = m(0, 0) * p.xb + m(1, 0) * p.yb + m(2, 0);
    const Lanes line_a1 = m(0, 1) * p.xb + m(1, 1) * p.yb + m(2, 1);
    error = p.xb * line_b0 + p.yb * line_b1 + line_b2;
    b0 = line_b0 * (1 / (scale.bx * scale.bx));
    b1 = line_b1 * (1 / (scale.by * scale.by));
    a0 = line_a0 * (1 / (scale.ax * scale.ax));
    a1 = line_a1 * (1 / (scale.ay * scale.ay));
    norm2 = b0 * line_b0 + b1 * line_b1 + a0 * line_a0 + a1 * line_a1;
  }
};

/// Signed Sampson distances and their derivatives by the nine entries of M, row by row.
Lanes sampson_gradient(const Mat3& m, const TwoMatches& p, const PixelScale& scale, Lanes (&gradient)[9]) {
  const EpipolarLines lines(m, p, scale);
  const Lanes inverse2 = 1.0 / lines.norm2;
  const Lanes inverse = {std::sqrt(inverse2[0]), std::sqrt(inverse2[1])};
  const Lanes residual = lines.error * inverse;
  // d(error / norm) = d(error) / norm - residual / norm^2 * (b0 d(line_b0) + ...)
  const Lanes k = residual * inverse2;
  const Lanes row0 = p.xb * inverse - k * lines.b0;
  const Lanes row1 = p.yb * inverse - k * lines.b1;
  const Lanes ka0 = k * lines.a0;
  const Lanes ka1 = k * lines.a1;
  gradient[0] = row0 * p.xa - ka0 * p.xb;
  gradient[1] = row0 * p.ya - ka1 * p.xb;
  gradient[2] = row0;
  gradient[3] = row1 * p.xa - ka0 * p.yb;
  gradient[4] = row1 * p.ya - ka1 * p.yb;
  gradient[5] = row1;
  gradient[6] = inverse * p.xa - ka0;
  gradient[7] = inverse * p.ya - ka1;
  gradient[8] = inverse;
  return residual;
}

/// Normal equations for the nine entries of M; a parametrisation takes its part of them.
struct EntryEquations {
  Lanes hessian[9][9] = {};  ///< lower triangle
  Lanes gradient[9] = {};

  void add(const Lanes (&g)[9], Lanes weight, Lanes residual) {
    for (int r = 0; r < 9; ++r) {
      const Lanes weighted = weight * g[r];
      gradient[r] += weighted * residual;
      for (int c = 0; c <= r; ++c) hessian[r][c] += weighted * g[c];
    }
  }

  template <int Dof>
  void project(const Mat3 (&directions)[Dof], NormalEquations<Dof>& equations) const {
    double d[Dof][9];
    for (int k = 0; k < Dof; ++k) {
      for (int e = 0; e < 9; ++e) d[k][e] = directions[k](e / 3, e % 3);
    }
    for (int k = 0; k < Dof; ++k) {
      double moved[9] = {};  // hessian * direction k
      double along = 0;
      for (int r = 0; r < 9; ++r) {
        along += (gradient[r][0] + gradient[r][1]) * d[k][r];
        for (int c = 0; c < 9; ++c) {
          const Lanes& entry = c <= r ? hessian[r][c] : hessian[c][r];
          moved[r] += (entry[0] + entry[1]) * d[k][c];
        }
      }
      equations.gradient[k] = along;
      for (int l = 0; l <= k; ++l) {
        double sum = 0;
        for (int e = 0; e < 9; ++e) sum += moved[e] * d[l][e];
        equations.hessian(k, l) = sum;
        equations.hessian(l, k) = sum;
      }
    }
  }
};

/// What is common to both parametrisations: M(state) and the directions in which the parameters move it.
template <class Parametrisation>
struct SampsonProblem {
  using State = typename Parametrisation::State;
  static constexpr int dof = Parametrisation::dof;
  using Step = Eigen::Matrix<double, dof, 1>;

  const NormalisedPairs& pairs;
  const PairSelection& selection;
  const RefinementParams& params;

  /// Matches i and i + 1, or the last one twice.
  [[nodiscard]] TwoMatches matches(std::size_t i) const {
    const std::size_t next = i + 1 < selection.count ? i + 1 : i;
    return {pairs.exact[selection.indices[i]], pairs.exact[selection.indices[next]]};
  }

  void linearise(const State& state, NormalEquations<dof>& equations) const {
    const Mat3 m = Parametrisation::matrix(state);
    Mat3 directions[dof];
    Parametrisation::directions(state, directions);
    equations = {};
    const double bound2 = params.bound_px * params.bound_px;
    EntryEquations sums;
    for (std::size_t i = 0; i < selection.count; i += 2) {
      Lanes gradient[9];
      Lanes residual = sampson_gradient(m, matches(i), pairs.scale, gradient);
      Lanes weight = {0, 0};
      for (int lane = 0; lane < (i + 1 < selection.count ? 2 : 1); ++lane) {
        const RobustCost value = robust_cost(params.loss, residual[lane] * residual[lane], bound2);
        equations.cost += value.cost;
        weight[lane] = value.weight;
      }
      if (!(weight[0] > 0) && !(weight[1] > 0)) continue;
      for (int lane = 0; lane < 2; ++lane) {
        if (weight[lane] > 0) continue;
        residual[lane] = 0;  // neither may be NaN
        for (Lanes& entry : gradient) entry[lane] = 0;
      }
      sums.add(gradient, weight, residual);
    }
    sums.project(directions, equations);
  }

  double cost(const State& state) const {
    const Mat3 m = Parametrisation::matrix(state);
    const double bound2 = params.bound_px * params.bound_px;
    double sum = 0;
    for (std::size_t i = 0; i < selection.count; i += 2) {
      const EpipolarLines lines(m, matches(i), pairs.scale);
      const Lanes squared = lines.error * lines.error / lines.norm2;
      sum += robust_cost(params.loss, squared[0], bound2).cost;
      if (i + 1 < selection.count) sum += robust_cost(params.loss, squared[1], bound2).cost;
    }
    return sum;
  }

  State moved(const State& state, const Step& step) const { return Parametrisation::moved(state, step); }
};

/// Two unit vectors orthogonal to the unit vector t and to each other.
void tangents(const Vec3& t, Vec3& u, Vec3& v) {
  const int smallest = std::fabs(t.x()) <= std::fabs(t.y()) && std::fabs(t.x()) <= std::fabs(t.z()) ? 0
                       : std::fabs(t.y()) <= std::fabs(t.z())                                       ? 1
                                                                                                    : 2;
  u = t.cross(Vec3::Unit(smallest)).normalized();
  v = t.cross(u);
}

/// R exp(w), t turned by two angles on the unit sphere.
struct PoseParametrisation {
  using State = RigidTransform;
  static constexpr int dof = 5;

  static Mat3 matrix(const State& pose) { return essential_from_pose(pose); }

  static void directions(const State& pose, Mat3 (&d)[dof]) {
    const Mat3 e = essential_from_pose(pose);
    for (int k = 0; k < 3; ++k) d[k] = e * cross_matrix(Vec3::Unit(k));
    Vec3 u;
    Vec3 v;
    tangents(pose.translation, u, v);
    d[3] = cross_matrix(u) * pose.rotation;
    d[4] = cross_matrix(v) * pose.rotation;
  }

  static State moved(const State& pose, const Eigen::Matrix<double, dof, 1>& step) {
    Vec3 u;
    Vec3 v;
    tangents(pose.translation, u, v);
    return {pose.rotation * rotation_from_vector(step.head<3>()),
            (pose.translation + step[3] * u + step[4] * v).normalized()};
  }
};

/// Noise of the matches makes derivatives out of nothing: J^T J counts them as information, and where a plane or
/// forward motion leaves little true information, they are most of it. Their expectation is sigma^2 sum g_k g_l /
/// |grad|^2, g_k being the derivative of direction k's algebraic error by the match, across the gradient of the error
/// itself. Source: K. Kanatani, "Statistical Optimization for Geometric Computation", 1996, 9.4 (renormalisation).
class NoiseInformation {
 public:
  static constexpr int dof = PoseParametrisation::dof;

  NoiseInformation(const RigidTransform& pose, const PixelScale& scale) : m_(essential_from_pose(pose)), scale_(scale) {
    PoseParametrisation::directions(pose, directions_);
  }

  void add(const NormalisedPair& p) {
    const Eigen::Vector4d normal = by_match(m_, p);
    const double inverse2 = 1 / normal.squaredNorm();
    Eigen::Vector4d across[dof];
    for (int k = 0; k < dof; ++k) {
      const Eigen::Vector4d g = by_match(directions_[k], p);
      across[k] = g - (normal.dot(g) * inverse2) * normal;
    }
    for (int k = 0; k < dof; ++k) {
      for (int l = 0; l <= k; ++l) sum_(k, l) += inverse2 * across[k].dot(across[l]);
    }
  }

  /// Expectation of J^T J of noise of one pixel.
  [[nodiscard]] Eigen::Matrix<double, dof, dof> value() const { return sum_.template selfadjointView<Eigen::Lower>(); }

 private:
  [[nodiscard]] Eigen::Vector4d by_match(const Mat3& m, const NormalisedPair& p) const {
    return {(m(0, 0) * p.xb + m(1, 0) * p.yb + m(2, 0)) / scale_.ax,
            (m(0, 1) * p.xb + m(1, 1) * p.yb + m(2, 1)) / scale_.ay,
            (m(0, 0) * p.xa + m(0, 1) * p.ya + m(0, 2)) / scale_.bx,
            (m(1, 0) * p.xa + m(1, 1) * p.ya + m(1, 2)) / scale_.by};
  }

  Mat3 m_;
  Mat3 directions_[dof];
  const PixelScale& scale_;
  Eigen::Matrix<double, dof, dof> sum_ = Eigen::Matrix<double, dof, dof>::Zero();
};

/// U exp(a) diag(1, s, 0) (V exp(b))^T: 3 + 3 + 1 parameters.
struct FundamentalState {
  Mat3 u, v;
  double s;
};

struct FundamentalParametrisation {
  using State = FundamentalState;
  static constexpr int dof = 7;

  static Mat3 matrix(const State& f) {
    return f.u.col(0) * f.v.col(0).transpose() + f.s * f.u.col(1) * f.v.col(1).transpose();
  }

  static void directions(const State& f, Mat3 (&d)[dof]) {
    const Mat3 diagonal = Vec3(1, f.s, 0).asDiagonal();
    for (int k = 0; k < 3; ++k) {
      const Mat3 turn = cross_matrix(Vec3::Unit(k));
      d[k] = f.u * turn * diagonal * f.v.transpose();
      d[3 + k] = -(f.u * diagonal * turn * f.v.transpose());
    }
    d[6] = f.u.col(1) * f.v.col(1).transpose();
  }

  static State moved(const State& f, const Eigen::Matrix<double, dof, 1>& step) {
    return {f.u * rotation_from_vector(step.head<3>()), f.v * rotation_from_vector(step.segment<3>(3)), f.s + step[6]};
  }
};

/// The frames turn about the directions to the middles, the depth ratio and the turn by shares, so that the turn keeps
/// its sign.
struct NarrowParametrisation {
  using State = NarrowMotion;
  static constexpr int dof = 5;

  static Mat3 matrix(const State& motion) { return cross_matrix(motion.translation()) * motion.rotation(); }

  static void directions(const State& motion, Mat3 (&d)[dof]) {
    const Mat3 r = motion.rotation();
    const Mat3 t = cross_matrix(motion.translation());
    const Vec3 axis = motion.frame_b.col(0);
    const auto turned = [&](const Mat3& by, const Vec3& offset) {
      return Mat3(cross_matrix(offset - motion.depth_ratio * (by * motion.middle_a)) * r + t * by);
    };
    d[0] = turned(-(r * cross_matrix(motion.frame_a.col(2))), Vec3::Zero());
    d[1] = turned(cross_matrix(motion.frame_b.col(2)) * r, motion.offset * motion.frame_b.col(1));
    d[2] = cross_matrix(-motion.depth_ratio * (r * motion.middle_a)) * r;
    d[3] = cross_matrix(axis) * r;
    d[4] = turned(motion.turn_rad * cross_matrix(axis) * r, Vec3::Zero());
  }

  static State moved(const State& motion, const Eigen::Matrix<double, dof, 1>& step) {
    State result = motion;
    result.frame_a = motion.frame_a * rotation_from_vector(Vec3(0, 0, step[0]));
    result.frame_b = motion.frame_b * rotation_from_vector(Vec3(0, 0, step[1]));
    result.depth_ratio *= det_exp(std::clamp(step[2], -1.0, 1.0));
    result.offset += step[3];
    result.turn_rad *= det_exp(std::clamp(step[4], -1.0, 1.0));
    return result;
  }
};

}  // namespace

bool refine_narrow_motion(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          NarrowMotion& motion) {
  if (selection.count < NarrowParametrisation::dof) return false;
  SampsonProblem<NarrowParametrisation> problem{pairs, selection, params};
  return minimise(problem, motion, params.max_steps, params.min_gain);
}

bool refine_relative_pose(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          RigidTransform& b_from_a) {
  if (selection.count < PoseParametrisation::dof) return false;
  SampsonProblem<PoseParametrisation> problem{pairs, selection, params};
  return minimise(problem, b_from_a, params.max_steps, params.min_gain);
}

double epipolar_cost(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                     const RigidTransform& b_from_a) {
  return SampsonProblem<PoseParametrisation>{pairs, selection, params}.cost(b_from_a);
}

bool refine_fundamental(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                        Mat3& fundamental) {
  if (selection.count < FundamentalParametrisation::dof) return false;
  SingularValues svd;
  if (!singular_values(fundamental, svd)) return false;
  FundamentalState state{svd.u, svd.v, svd.values[1] / svd.values[0]};
  SampsonProblem<FundamentalParametrisation> problem{pairs, selection, params};
  if (!minimise(problem, state, params.max_steps, params.min_gain)) return false;
  fundamental = FundamentalParametrisation::matrix(state);
  return true;
}

void pose_uncertainty(const NormalisedPairs& pairs, const PairSelection& selection, const RigidTransform& b_from_a,
                      double sigma_px, double& sigma_rotation_rad, double& sigma_direction_rad) {
  sigma_rotation_rad = std::numeric_limits<double>::infinity();
  sigma_direction_rad = std::numeric_limits<double>::infinity();
  if (selection.count < PoseParametrisation::dof) return;
  RefinementParams params;
  params.bound_px = 1e6;
  const SampsonProblem<PoseParametrisation> problem{pairs, selection, params};
  NormalEquations<5> equations;
  problem.linearise(b_from_a, equations);
  NoiseInformation noise(b_from_a, pairs.scale);
  for (std::size_t i = 0; i < selection.count; ++i) noise.add(pairs.exact[selection.indices[i]]);
  const Eigen::Matrix<double, 5, 5> made_by_noise = sigma_px * sigma_px * noise.value();
  // What noise makes scatters by this share of its expectation; so that luck is not taken for information, all of it is
  // subtracted once more, and half of it stays as the least that is believed.
  const double scatter = std::sqrt(2 / static_cast<double>(selection.count));
  SymmetricEigen<5> eigen;
  if (!symmetric_eigen<5>(equations.hessian - (1 + scatter) * made_by_noise, eigen)) return;
  for (int i = 0; i < 5; ++i) {
    const double least = 0.5 * scatter * eigen.vectors.col(i).dot(made_by_noise * eigen.vectors.col(i));
    eigen.values[i] = std::fmax(eigen.values[i], least);
  }
  if (!(eigen.values.minCoeff() > 1e-10 * eigen.values.maxCoeff())) return;
  const Eigen::Matrix<double, 5, 5> covariance =
      eigen.vectors * eigen.values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  SymmetricEigen<3> rotation;
  if (!symmetric_eigen<3>(covariance.topLeftCorner<3, 3>(), rotation)) return;
  // The larger eigenvalue of a symmetric 2x2 matrix.
  const double half_sum = 0.5 * (covariance(3, 3) + covariance(4, 4));
  const double half_difference = 0.5 * (covariance(3, 3) - covariance(4, 4));
  const double largest = half_sum + std::sqrt(half_difference * half_difference + covariance(3, 4) * covariance(3, 4));
  sigma_rotation_rad = sigma_px * std::sqrt(rotation.values[2]);
  sigma_direction_rad = sigma_px * std::sqrt(largest);
}

}  // namespace ilp
