#include "sim/ground/model/common_errors.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

namespace ilp::model {
namespace {

constexpr double significant_sigmas = 3;

/// Residuals in one part of an image.
struct PartSums {
  double count = 0;
  Vec2 sum = Vec2::Zero(), squares = Vec2::Zero();
};

double factor_in_parts(const AdjustmentProblem& problem, const std::vector<Vec2>& residuals, double parts_per_width) {
  std::map<std::tuple<std::uint32_t, long, long>, PartSums> parts;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const AdjustedObservation& seen = problem.observations[i];
    const double side = 2 * problem.cameras[seen.camera].cx / parts_per_width;
    PartSums& part =
        parts[{seen.camera, std::lround(std::floor(seen.x / side)), std::lround(std::floor(seen.y / side))}];
    part.count += 1;
    part.sum += residuals[i];
    part.squares += residuals[i].cwiseAbs2();
  }
  double of_sums = 0, independent = 0, counts = 0, squared_counts = 0;
  for (const auto& [place, part] : parts) {
    of_sums += part.sum.squaredNorm();
    independent += part.squares.sum();
    counts += 2 * part.count;
    squared_counts += 2 * part.count * part.count;
  }
  if (!(independent > 0)) return 1;
  const double factor = of_sums / independent, sigma = std::sqrt(2 * squared_counts) / counts;
  return factor > 1 + significant_sigmas * sigma ? factor : 1;
}

}  // namespace

double common_error_factor(const AdjustmentProblem& problem, double robust_px) {
  std::vector<Vec2> residuals;
  for (const AdjustedObservation& seen : problem.observations) {
    const AdjustedCamera& camera = problem.cameras[seen.camera];
    const Vec3 p = camera.cam_from_world * (problem.points[seen.point] - camera.centre);
    const Vec2 error(camera.fx * p.x() / p.z() + camera.cx - seen.x, camera.fy * p.y() / p.z() + camera.cy - seen.y);
    residuals.push_back(error / std::sqrt(1 + error.squaredNorm() / (robust_px * robust_px)));
  }
  double factor = 1;
  for (const double parts_per_width : {4.0, 8.0, 16.0})
    factor = std::max(factor, factor_in_parts(problem, residuals, parts_per_width));
  return factor;
}

}  // namespace ilp::model
