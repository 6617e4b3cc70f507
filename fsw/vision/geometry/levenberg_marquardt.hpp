// The Levenberg-Marquardt method, one step per call, for any number of unknowns.
#pragma once

#include <cmath>
#include <cstdint>

namespace ilp {

/// State of a minimisation between its steps; the problem has the estimate.
struct LevenbergMarquardt {
  double damping = 1e-4;  ///< factor of the diagonal of the normal equations; small, for starts near the minimum
  double damping_growth = 2;
  double cost = 0;               ///< half the sum of squared residuals or of their losses, >= 0
  std::uint32_t iterations = 0;  ///< accepted and rejected steps
  bool converged = false;
  bool done = false;
};

struct TrialStep {
  double cost = 0;           ///< after the step; not finite if the step is invalid
  double expected_gain = 0;  ///< decrease of the cost if the residuals were linear
};

/// Tries one step of `problem`, whose cost is `state.cost`, and accepts it if the cost falls. Problem provides
///   bool try_step(double damping, TrialStep&);  // from the present estimate, which stays; false without a solution
///   void accept();                              // moves to where the last step led
/// `state.done` becomes true after `max_iterations`, if the damping becomes useless, or with `state.converged`. The
/// search has converged if a step lowers the cost by at most `tolerance` times the cost. If a step does not lower the
/// cost, its expected gain is compared instead, because rounding then hides the gain. Damping after H. B. Nielsen,
/// "Damping Parameter in Marquardt's Method", IMM-REP-1999-05.
template <class Problem>
void levenberg_marquardt_step(Problem& problem, std::uint32_t max_iterations, double tolerance,
                              LevenbergMarquardt& state) {
  constexpr double least_damping = 1e-10, most_damping = 1e16;
  ++state.iterations;
  TrialStep trial;
  const bool valid = problem.try_step(state.damping, trial) && std::isfinite(trial.cost);
  const double gain = state.cost - trial.cost;
  state.converged = valid && (gain >= 0 ? gain : trial.expected_gain) <= tolerance * state.cost;
  if (valid && gain > 0) {
    problem.accept();
    state.cost = trial.cost;
    const double ratio = trial.expected_gain > 0 ? gain / trial.expected_gain : 1, centred = 2 * ratio - 1;
    state.damping *= std::fmax(1.0 / 3, 1 - centred * centred * centred);
    state.damping = std::fmax(state.damping, least_damping);
    state.damping_growth = 2;
  } else {
    state.damping *= state.damping_growth;
    state.damping_growth *= 2;
  }
  state.done = state.converged || state.iterations >= max_iterations || !(state.damping < most_damping);
}

}  // namespace ilp
