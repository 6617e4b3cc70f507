#include "sim/ground/model/adjustment.hpp"

#include <cmath>

#include "fsw/vision/geometry/levenberg_marquardt.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/model/normal_equations.hpp"

namespace ilp::model {
namespace {

/// Long chains bend by little resistance: damping that is not far below it makes them straight in many small steps.
constexpr double first_damping = 1e-8;

struct AdjustmentSteps {
  AdjustmentProblem& problem;
  ResidualWeights weights;
  NormalEquations equations = NormalEquations(problem);
  // Points and cameras alone: observations stay where they are.
  std::vector<AdjustedCamera> cameras = {};
  std::vector<Vec3> points = {};

  bool try_step(double damping, TrialStep& trial) {
    const auto step = equations.step(problem, weights, damping);
    if (!step) return false;
    cameras = problem.cameras;
    points = problem.points;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      cameras[c].cam_from_world = rotation_from_vector(step->cameras[c].head<3>()) * cameras[c].cam_from_world;
      cameras[c].centre += step->cameras[c].tail<3>();
    }
    for (std::size_t p = 0; p < points.size(); ++p) points[p] += step->points[p];
    swap();
    trial = {cost_of(problem, weights), step->expected};
    swap();
    return true;
  }
  void accept() { swap(); }
  void swap() {
    problem.cameras.swap(cameras);
    problem.points.swap(points);
  }
};

}  // namespace

Gauge gauge_of(const AdjustmentProblem& problem) {
  std::vector<std::uint8_t> observing(problem.cameras.size(), 0);
  for (const AdjustedObservation& seen : problem.observations) observing[seen.camera] = 1;
  Gauge gauge;
  while (gauge.first + 1 < problem.cameras.size() && observing[gauge.first] == 0) ++gauge.first;
  gauge.anchor = gauge.first;
  double longest = 0;
  for (std::uint32_t c = gauge.first + 1; c < problem.cameras.size(); ++c) {
    if (observing[c] == 0) continue;
    for (int k = 0; k < 3; ++k) {
      const double length = std::fabs(problem.cameras[c].centre[k] - problem.cameras[gauge.first].centre[k]);
      if (length <= longest) continue;
      longest = length;
      gauge.anchor = c;
      gauge.component = k;
    }
  }
  return gauge;
}

Adjusted adjust(AdjustmentProblem& problem, const AdjustmentParams& params) {
  if (problem.cameras.empty() || problem.observations.empty()) return {};
  AdjustmentSteps steps{problem, {params.robust_px}};
  const double before = cost_of(problem, steps.weights);
  LevenbergMarquardt descent{.damping = first_damping, .cost = before, .done = !std::isfinite(before)};
  while (!descent.done) levenberg_marquardt_step(steps, params.max_iterations, params.tolerance, descent);
  return {descent.cost < before, descent.iterations, descent.cost};
}

}  // namespace ilp::model
