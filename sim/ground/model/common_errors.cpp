#include "sim/ground/model/common_errors.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ilp::model {
namespace {

constexpr double significant_sigmas = 3;
/// Parts outside the image, as multiples of its width: those beyond are one.
constexpr double farthest = 1;

/// Residuals in one part of an image.
struct PartSums {
  double count = 0;
  Vec2 sum = Vec2::Zero(), squares = Vec2::Zero();
};

struct Place {
  std::size_t x = 0, y = 0;
};

/// In which part of its image each observation lies, counted from the outermost one that holds any.
std::vector<Place> places_of(const AdjustmentProblem& problem, double parts_per_width) {
  std::vector<Place> places;
  places.reserve(problem.observations.size());
  const double least = -farthest * parts_per_width, most = (1 + farthest) * parts_per_width;
  for (const AdjustedObservation& seen : problem.observations) {
    const double side = 2 * problem.cameras[seen.camera].cx / parts_per_width;
    const auto part = [&](double c) {
      return static_cast<std::size_t>(std::clamp(std::floor(c / side), least, most) - least);
    };
    places.push_back({part(seen.x), part(seen.y)});
  }
  Place first = places.empty() ? Place{} : places.front();
  for (const Place& place : places) first = {std::min(first.x, place.x), std::min(first.y, place.y)};
  for (Place& place : places) place = {place.x - first.x, place.y - first.y};
  return places;
}

CommonErrors::InParts errors_in_parts(const AdjustmentProblem& problem, const std::vector<Vec2>& residuals,
                                      double parts_per_width) {
  const std::vector<Place> places = places_of(problem, parts_per_width);
  std::size_t columns = 1, rows = 1;
  for (const Place& place : places) {
    columns = std::max(columns, place.x + 1);
    rows = std::max(rows, place.y + 1);
  }
  std::vector<PartSums> parts(problem.cameras.size() * columns * rows);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    PartSums& part = parts[(problem.observations[i].camera * columns + places[i].x) * rows + places[i].y];
    part.count += 1;
    part.sum += residuals[i];
    part.squares += residuals[i].cwiseAbs2();
  }
  CommonErrors::InParts errors;
  for (const PartSums& part : parts) {
    errors.of_sums += part.sum.squaredNorm();
    errors.independent += part.squares.sum();
    errors.counts += 2 * part.count;
    errors.squared_counts += 2 * part.count * part.count;
  }
  return errors;
}

}  // namespace

void CommonErrors::add(const CommonErrors& other) {
  for (std::size_t k = 0; k < in_parts.size(); ++k) {
    in_parts[k].of_sums += other.in_parts[k].of_sums;
    in_parts[k].independent += other.in_parts[k].independent;
    in_parts[k].counts += other.in_parts[k].counts;
    in_parts[k].squared_counts += other.in_parts[k].squared_counts;
  }
}

double CommonErrors::factor() const {
  double largest = 1;
  for (const InParts& parts : in_parts) {
    if (!(parts.independent > 0)) continue;
    const double ratio = parts.of_sums / parts.independent, sigma = std::sqrt(2 * parts.squared_counts) / parts.counts;
    if (ratio > 1 + significant_sigmas * sigma) largest = std::max(largest, ratio);
  }
  return largest;
}

CommonErrors common_errors_of(const AdjustmentProblem& problem, double robust_px) {
  std::vector<Vec2> residuals;
  residuals.reserve(problem.observations.size());
  for (const AdjustedObservation& seen : problem.observations) {
    const AdjustedCamera& camera = problem.cameras[seen.camera];
    const Vec3 p = camera.cam_from_world * (problem.points[seen.point] - camera.centre);
    const Vec2 error(camera.fx * p.x() / p.z() + camera.cx - seen.x, camera.fy * p.y() / p.z() + camera.cy - seen.y);
    residuals.push_back(error / std::sqrt(1 + error.squaredNorm() / (robust_px * robust_px)));
  }
  CommonErrors errors;
  for (std::size_t k = 0; k < errors.in_parts.size(); ++k)
    errors.in_parts[k] = errors_in_parts(problem, residuals, CommonErrors::parts_per_width[k]);
  return errors;
}

}  // namespace ilp::model
