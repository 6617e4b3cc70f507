#include "sim/score/height_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "sim/ground/statistics.hpp"

namespace ilp::score {
namespace {

constexpr int slices_of_track = 40;

/// Level unit vector from the first to the farthest centre.
Vec3 main_direction(const std::vector<Vec3>& centres) {
  Vec3 farthest = Vec3::Zero();
  for (const Vec3& centre : centres) {
    const Vec3 way(centre.x() - centres[0].x(), centre.y() - centres[0].y(), 0);
    if (way.norm() > farthest.norm()) farthest = way;
  }
  return farthest.norm() > 0 ? Vec3(farthest.normalized()) : Vec3(Vec3::UnitX());
}

class Profile {
 public:
  Profile(const std::vector<Vec3>& centres, double flying_height) : direction_(main_direction(centres)) {
    if (centres.empty()) return;
    origin_ = centres[0];
    double length = 0;
    for (const Vec3& centre : centres) length = std::max(length, direction_.dot(centre - origin_));
    slice_ = std::max(length, flying_height) / slices_of_track;
  }

  void add(const Vec3& point, double error) {
    slices_[static_cast<long>(std::floor(direction_.dot(point - origin_) / slice_))].push_back(error);
  }

  [[nodiscard]] std::vector<HeightProfilePoint> points() const {
    std::vector<HeightProfilePoint> points;
    for (const auto& [slice, errors] : slices_) {
      points.push_back({(static_cast<double>(slice) + 0.5) * slice_, ground::median(errors), errors.size()});
    }
    return points;
  }

 private:
  Vec3 direction_, origin_ = Vec3::Zero();
  double slice_ = 1;
  std::map<long, std::vector<double>> slices_;
};

}  // namespace

HeightScore score_heights(const ground::GroundGrid& grid, const AlignedStrip& strip, const sim::HeightGrid& truth,
                          const std::vector<Vec3>& centres, double flying_height) {
  HeightScore score;
  score.flying_height = flying_height;
  score.error_map =
      ground::Raster<float>(grid.height.width, grid.height.height, std::numeric_limits<float>::quiet_NaN());
  const double percent = 100 / flying_height;
  Profile profile(centres, flying_height);
  for (std::int32_t j = 0; j < grid.height.height; ++j) {
    for (std::int32_t i = 0; i < grid.height.width; ++i) {
      const double z = grid.height.at(i, j);
      if (!std::isfinite(z)) continue;
      ++score.covered;
      const Vec3 cell(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell, z);
      const Vec3 point = strip.true_from_strip * cell;
      const double error = point.z() - sim::height_at(truth, point.x(), point.y());
      if (std::isfinite(error)) {
        score.error_map.at(i, j) = static_cast<float>(error);
        score.percent.push_back(static_cast<float>(percent * error));
        profile.add(point, error);
      }
      if (!strip.true_from_metric_strip) continue;
      const Vec3 as_flown = *strip.true_from_metric_strip * cell;
      const double metric_error = as_flown.z() - sim::height_at(truth, as_flown.x(), as_flown.y());
      if (std::isfinite(metric_error)) score.metric_percent.push_back(static_cast<float>(percent * metric_error));
    }
  }
  score.error = error_percent(score.percent);
  if (strip.true_from_metric_strip) score.metric = error_percent(score.metric_percent);
  score.profile = profile.points();
  return score;
}

}  // namespace ilp::score
