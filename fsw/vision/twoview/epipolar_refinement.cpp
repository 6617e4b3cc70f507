#include "fsw/vision/twoview/epipolar_refinement.hpp"

#include <cmath>
#include <limits>

#include "fsw/vision/twoview/decompose_essential.hpp"
#include "fsw/vision/twoview/epipolar_error.hpp"
#include "fsw/vision/twoview/levenberg_marquardt.hpp"
#include "fsw/vision/twoview/singular_values.hpp"
#include "fsw/vision/twoview/symmetric_eigen.hpp"

namespace ilp {
namespace {

struct Robust {
  double cost;
  double weight;
};

Robust robust(RobustLoss loss, double squared, double bound2) {
  if (!(squared < bound2)) return {loss == RobustLoss::tukey ? bound2 / 3 : bound2, 0};
  if (loss == RobustLoss::truncated) return {squared, 1};
  const double rest = 1 - squared / bound2;
  return {bound2 / 3 * (1 - rest * rest * rest), rest * rest};
}

/// Signed Sampson distance and its derivative by the nine entries of M.
double sampson_gradient(const Mat3& m, const NormalisedPair& p, const PixelScale& scale, Mat3& gradient) {
  const double line_b0 = m(0, 0) * p.xa + m(0, 1) * p.ya + m(0, 2);
  const double line_b1 = m(1, 0) * p.xa + m(1, 1) * p.ya + m(1, 2);
  const double line_b2 = m(2, 0) * p.xa + m(2, 1) * p.ya + m(2, 2);
  const double line_a0 = m(0, 0) * p.xb + m(1, 0) * p.yb + m(2, 0);
  const double line_a1 = m(0, 1) * p.xb + m(1, 1) * p.yb + m(2, 1);
  const double error = p.xb * line_b0 + p.yb * line_b1 + line_b2;
  const double b0 = line_b0 / (scale.bx * scale.bx);
  const double b1 = line_b1 / (scale.by * scale.by);
  const double a0 = line_a0 / (scale.ax * scale.ax);
  const double a1 = line_a1 / (scale.ay * scale.ay);
  const double norm2 = b0 * line_b0 + b1 * line_b1 + a0 * line_a0 + a1 * line_a1;
  const double inverse = 1 / std::sqrt(norm2);
  const double residual = error * inverse;
  // d(error / norm) = d(error) / norm - residual / norm^2 * (b0 d(line_b0) + ...)
  const double k = residual * inverse * inverse;
  const double row0 = p.xb * inverse - k * b0;
  const double row1 = p.yb * inverse - k * b1;
  const double row2 = inverse;
  const double ka0 = k * a0;
  const double ka1 = k * a1;
  gradient(0, 0) = row0 * p.xa - ka0 * p.xb;
  gradient(0, 1) = row0 * p.ya - ka1 * p.xb;
  gradient(0, 2) = row0;
  gradient(1, 0) = row1 * p.xa - ka0 * p.yb;
  gradient(1, 1) = row1 * p.ya - ka1 * p.yb;
  gradient(1, 2) = row1;
  gradient(2, 0) = row2 * p.xa - ka0;
  gradient(2, 1) = row2 * p.ya - ka1;
  gradient(2, 2) = row2;
  return residual;
}

/// What is common to both parametrisations: M(state) and the directions in which the parameters move it.
template <class Parametrisation>
struct SampsonProblem {
  using State = typename Parametrisation::State;
  static constexpr int dof = Parametrisation::dof;
  using Step = Eigen::Matrix<double, dof, 1>;

  const NormalisedPairs& pairs;
  const PairSelection& selection;
  const RefinementParams& params;

  void linearise(const State& state, NormalEquations<dof>& equations) const {
    const Mat3 m = Parametrisation::matrix(state);
    Mat3 directions[dof];
    Parametrisation::directions(state, directions);
    equations = {};
    const double bound2 = params.bound_px * params.bound_px;
    for (std::size_t i = 0; i < selection.count; ++i) {
      Mat3 gradient;
      const NormalisedPair& pair = pairs.exact[selection.indices[i]];
      const double residual = sampson_gradient(m, pair, pairs.scale, gradient);
      const Robust value = robust(params.loss, residual * residual, bound2);
      equations.cost += value.cost;
      if (!(value.weight > 0)) continue;
      double jacobian[dof];
      for (int k = 0; k < dof; ++k) {
        double sum = 0;
        for (int e = 0; e < 9; ++e) sum += gradient.data()[e] * directions[k].data()[e];
        jacobian[k] = sum;
      }
      for (int k = 0; k < dof; ++k) {
        const double weighted = value.weight * jacobian[k];
        equations.gradient[k] += weighted * residual;
        for (int l = 0; l <= k; ++l) equations.hessian(k, l) += weighted * jacobian[l];
      }
    }
    for (int k = 0; k < dof; ++k) {
      for (int l = 0; l < k; ++l) equations.hessian(l, k) = equations.hessian(k, l);
    }
  }

  double cost(const State& state) const {
    const Mat3 m = Parametrisation::matrix(state);
    const double bound2 = params.bound_px * params.bound_px;
    double sum = 0;
    for (std::size_t i = 0; i < selection.count; ++i) {
      sum += robust(params.loss, sampson_squared(m, pairs.exact[selection.indices[i]], pairs.scale), bound2).cost;
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

}  // namespace

bool refine_relative_pose(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                          RigidTransform& b_from_a) {
  if (selection.count < PoseParametrisation::dof) return false;
  SampsonProblem<PoseParametrisation> problem{pairs, selection, params};
  return levenberg_marquardt(problem, b_from_a, params.max_steps, params.min_gain);
}

bool refine_fundamental(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                        Mat3& fundamental) {
  if (selection.count < FundamentalParametrisation::dof) return false;
  SingularValues svd;
  if (!singular_values(fundamental, svd)) return false;
  FundamentalState state{svd.u, svd.v, svd.values[1] / svd.values[0]};
  SampsonProblem<FundamentalParametrisation> problem{pairs, selection, params};
  if (!levenberg_marquardt(problem, state, params.max_steps, params.min_gain)) return false;
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
