// Levenberg-Marquardt's method, step by step, for any number of unknowns.
#pragma once

#include <cmath>
#include <cstdint>

namespace ilp {

/// State of a minimisation between its steps, in addition to the problem itself.
struct LevenbergMarquardt {
  double damping = 1e-4;  ///< times the diagonal of the normal equations; small, for starts near the minimum
  double damping_growth = 2;
  double cost = 0;               ///< half the sum of squared residuals, or of their losses; at least 0
  std::uint32_t iterations = 0;  ///< accepted and rejected ones
  bool converged = false;
  bool done = false;
};

struct TrialStep {
  double cost = 0;           ///< not finite where the step leads nowhere
  double expected_gain = 0;  ///< by which the cost falls if the residuals are linear
};

/// Tries one step of `problem`, whose cost is `state.cost`, and takes it where the cost falls. Problem provides
///   bool try_step(double damping, TrialStep&);  // from the present estimate, which stays; false without a solution
///   void accept();                              // moves to where the last step led
/// The state is done after `max_iterations`, with a damping beyond all use, or converged: when a step gains no more
/// than the share `tolerance` of the cost, or promises no more and yet gains nothing, which is rounding. Damping after
/// H. B. Nielsen, "Damping Parameter in Marquardt's Method", IMM-REP-1999-05.
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
