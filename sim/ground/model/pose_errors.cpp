#include "sim/ground/model/pose_errors.hpp"

#include "sim/ground/model/normal_equations.hpp"

namespace ilp::model {

PoseCovariance lower_triangle(const Mat6& covariance) {
  PoseCovariance triangle{};
  std::size_t k = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) triangle[k++] = covariance(row, column);
  }
  return triangle;
}

std::optional<double> variance_of_sightings(const AdjustmentProblem& problem) {
  const double residuals =
                   2.0 * static_cast<double>(problem.observations.size()) + static_cast<double>(problem.depths.size()),
               unknowns =
                   3.0 * static_cast<double>(problem.points.size()) + 6.0 * static_cast<double>(problem.cameras.size());
  if (!(residuals > unknowns)) return std::nullopt;
  return 2 * cost_of_points(problem, {0, 0}) / (residuals - unknowns);
}

std::vector<PoseCovariance> pose_covariances(const AdjustmentProblem& problem) {
  const std::optional<double> variance = variance_of_sightings(problem);
  if (problem.cameras.size() < 2 || !variance) return {};
  // Depths are in units of their errors already, and pixels are not.
  std::vector<PoseCovariance> errors;
  for (const Mat6& covariance : NormalEquations(problem).covariances(problem, {0, *variance}))
    errors.push_back(lower_triangle(*variance * covariance));
  return errors;
}

}  // namespace ilp::model
