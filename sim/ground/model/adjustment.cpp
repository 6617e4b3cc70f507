#include "sim/ground/model/adjustment.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/model/normal_equations.hpp"

namespace ilp::model {
namespace {

/// Long chains bend by little resistance: damping that is not far below it makes them straight in many small steps.
constexpr double first_damping = 1e-8, least_damping = 1e-10, most_damping = 1e12;

void take(const AdjustmentStep& step, AdjustmentProblem& problem) {
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    AdjustedCamera& camera = problem.cameras[c];
    camera.cam_from_world = rotation_from_vector(step.cameras[c].head<3>()) * camera.cam_from_world;
    camera.centre += step.cameras[c].tail<3>();
  }
  for (std::size_t p = 0; p < problem.points.size(); ++p) problem.points[p] += step.points[p];
}

/// H. Nielsen, "Damping Parameter in Marquardt's Method", 1999.
struct Damping {
  double value = first_damping, growth = 2;

  void after_success(double gained_share) {
    value = std::max(least_damping, value * std::max(1.0 / 3, 1 - std::pow(2 * gained_share - 1, 3)));
    growth = 2;
  }
  [[nodiscard]] bool after_failure() {
    value *= growth;
    growth *= 2;
    return value < most_damping;
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
  Adjusted adjusted;
  const ResidualWeights weights{params.robust_px};
  if (problem.cameras.empty() || problem.observations.empty()) return adjusted;
  adjusted.cost = cost_of(problem, weights);
  if (!std::isfinite(adjusted.cost)) return adjusted;
  NormalEquations equations(problem);
  // Points and cameras alone: observations stay where they are.
  std::vector<AdjustedCamera> cameras;
  std::vector<Vec3> points;
  Damping damping;
  while (adjusted.iterations < params.max_iterations) {
    ++adjusted.iterations;
    const auto step = equations.step(problem, weights, damping.value);
    if (step && step->expected < params.tolerance * adjusted.cost / 100) break;
    if (step) {
      cameras = problem.cameras;
      points = problem.points;
      take(*step, problem);
      const double cost = cost_of(problem, weights), gained = adjusted.cost - cost;
      if (gained > 0) {
        adjusted.moved = true;
        adjusted.cost = cost;
        if (gained < params.tolerance * cost) break;
        damping.after_success(gained / step->expected);
        continue;
      }
      problem.cameras = cameras;
      problem.points = points;
    }
    if (!damping.after_failure()) break;
  }
  return adjusted;
}

}  // namespace ilp::model
