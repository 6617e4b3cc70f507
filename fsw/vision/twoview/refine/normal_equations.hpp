// Minimises a robust cost of few unknowns by Levenberg-Marquardt.
#pragma once

#include "fsw/vision/geometry/levenberg_marquardt.hpp"
#include "fsw/vision/geometry/symmetric_solver.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

template <int Dof>
struct NormalEquations {
  Eigen::Matrix<double, Dof, Dof> hessian = Eigen::Matrix<double, Dof, Dof>::Zero();  ///< J^T W J
  Eigen::Matrix<double, Dof, 1> gradient = Eigen::Matrix<double, Dof, 1>::Zero();     ///< J^T W r
  double cost = 0;
};

/// Adapts a Problem to levenberg_marquardt_step(): its normal equations are solved as one dense system.
template <class Problem>
struct DenseSteps {
  using Vector = Eigen::Matrix<double, Problem::dof, 1>;

  const Problem& problem;
  typename Problem::State& state;
  typename Problem::State candidate = state;
  NormalEquations<Problem::dof> equations = {};
  bool linear_here = false;

  void linearise() {
    if (!linear_here) problem.linearise(state, equations);
    linear_here = true;
  }
  bool try_step(double damping, TrialStep& trial) {
    linearise();
    // Relative to each diagonal entry, plus a fraction of the trace for unconstrained parameters.
    const double floor = 1e-9 * equations.hessian.trace() / Problem::dof;
    const Vector added = (damping * equations.hessian.diagonal()).array() + floor;
    Eigen::Matrix<double, Problem::dof, Problem::dof> damped = equations.hessian;
    damped.diagonal() += added;
    const Vector step = solve_symmetric<Problem::dof>(damped, -equations.gradient);
    if (!step.allFinite()) return false;
    candidate = problem.moved(state, step);
    trial = {problem.cost(candidate), step.dot(added.cwiseProduct(step) - equations.gradient)};
    return true;
  }
  void accept() {
    state = candidate;
    linear_here = false;
  }
};

/// Minimises problem.cost over `state` by Levenberg-Marquardt. Problem provides `dof`, State,
///   void linearise(const State&, NormalEquations<dof>&);
///   double cost(const State&);
///   State moved(const State&, const Eigen::Matrix<double, dof, 1>& step);
/// Stops after `max_steps` trials, or if a step lowers the cost by less than `min_gain` times the cost. Returns false
/// if the cost did not fall.
template <class Problem>
bool minimise(const Problem& problem, typename Problem::State& state, std::uint32_t max_steps, double min_gain) {
  DenseSteps<Problem> steps{problem, state};
  steps.linearise();
  const double before = steps.equations.cost;
  LevenbergMarquardt descent{.cost = before};
  while (!descent.done) levenberg_marquardt_step(steps, max_steps, min_gain, descent);  // bound: max_steps
  return descent.cost < before;
}

}  // namespace ilp
