// Levenberg-Marquardt for a handful of parameters, on robust costs.
#pragma once

#include <cmath>

#include "fsw/vision/geometry/symmetric_solver.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

template <int Dof>
struct NormalEquations {
  Eigen::Matrix<double, Dof, Dof> hessian = Eigen::Matrix<double, Dof, Dof>::Zero();  ///< J^T W J
  Eigen::Matrix<double, Dof, 1> gradient = Eigen::Matrix<double, Dof, 1>::Zero();     ///< J^T W r
  double cost = 0;
};

/// Minimises problem.cost over `state`. Problem provides `dof`, State,
///   void linearise(const State&, NormalEquations<dof>&);
///   double cost(const State&);
///   State moved(const State&, const Eigen::Matrix<double, dof, 1>& step);
/// Stops after `max_steps` trials or when the cost falls by less than the share `min_gain`. Returns false when the cost
/// did not fall. Damping after H. B. Nielsen, "Damping Parameter in Marquardt's Method", 1999, simplified to factors of
/// ten.
template <class Problem>
bool levenberg_marquardt(Problem& problem, typename Problem::State& state, int max_steps, double min_gain) {
  NormalEquations<Problem::dof> equations;
  problem.linearise(state, equations);
  double damping = 1e-4;
  bool gained = false;
  for (int step = 0; step < max_steps; ++step) {
    Eigen::Matrix<double, Problem::dof, Problem::dof> damped = equations.hessian;
    // Relative to each diagonal entry, plus a fraction of the trace for unconstrained parameters.
    const double floor = 1e-9 * equations.hessian.trace() / Problem::dof;
    for (int i = 0; i < Problem::dof; ++i) damped(i, i) += damping * damped(i, i) + floor;
    const Eigen::Matrix<double, Problem::dof, 1> delta = solve_symmetric<Problem::dof>(damped, -equations.gradient);
    if (!delta.allFinite()) break;
    const typename Problem::State candidate = problem.moved(state, delta);
    const double cost = problem.cost(candidate);
    if (cost < equations.cost) {
      const bool converged = equations.cost - cost < min_gain * equations.cost;
      state = candidate;
      gained = true;
      if (converged || step + 1 == max_steps) break;
      damping = std::fmax(damping * 0.1, 1e-10);
      problem.linearise(state, equations);
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  return gained;
}

}  // namespace ilp
