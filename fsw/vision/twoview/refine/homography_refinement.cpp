#include "fsw/vision/twoview/refine/homography_refinement.hpp"

#include <cmath>

#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/refine/normal_equations.hpp"

namespace ilp {
namespace {

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

  [[nodiscard]] RobustCost cost_of(double squared) const {
    return robust_cost(params.loss, squared, params.bound_px * params.bound_px);
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
      const auto [cost, weight] = cost_of(residual_u * residual_u + residual_v * residual_v);
      equations.cost += cost;
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
      sum += cost_of(transfer_squared(state.h, pairs.exact[selection.indices[i]], pairs.scale)).cost;
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

bool refine_homography(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                       Mat3& homography) {
  if (selection.count < 4) return false;
  TransferProblem::State state{homography, 0};
  for (int e = 1; e < 9; ++e) {
    if (std::fabs(homography(e / 3, e % 3)) > std::fabs(homography(state.fixed / 3, state.fixed % 3))) state.fixed = e;
  }
  TransferProblem problem{pairs, selection, params};
  if (!minimise(problem, state, params.max_steps, params.min_gain)) return false;
  homography = state.h / state.h.norm();
  return true;
}

}  // namespace ilp
