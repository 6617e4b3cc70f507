#include "sim/tools/score/height_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "sim/host/statistics.hpp"

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
      points.push_back({(static_cast<double>(slice) + 0.5) * slice_, host::median(errors), errors.size()});
    }
    return points;
  }

 private:
  Vec3 direction_, origin_ = Vec3::Zero();
  double slice_ = 1;
  std::map<long, std::vector<double>> slices_;
};

/// Bilinear; NaN outside and beside holes.
double merged_height(const map::GroundGrid& grid, double x, double y) {
  const double column = grid.column_of(x), row = grid.row_of(y);
  const std::int32_t width = grid.height.width, height = grid.height.height;
  if (width < 2 || height < 2 || !(column >= 0) || !(row >= 0) || column > width - 1 || row > height - 1) {
    return unknown;
  }
  const std::int32_t i = std::min(static_cast<std::int32_t>(column), width - 2);
  const std::int32_t j = std::min(static_cast<std::int32_t>(row), height - 2);
  const double u = column - i, v = row - j;
  return (1 - v) * ((1 - u) * grid.height.at(i, j) + u * grid.height.at(i + 1, j)) +
         v * ((1 - u) * grid.height.at(i, j + 1) + u * grid.height.at(i + 1, j + 1));
}

host::Raster<float> map_errors(const map::GroundGrid& grid, const host::Similarity3& true_from_strip,
                               const world::HeightGrid& truth) {
  const host::Raster<float>& heights = truth.height_m;
  host::Raster<float> map(heights.width, heights.height, std::numeric_limits<float>::quiet_NaN());
  const Mat3 strip_from_true = true_from_strip.rotation.transpose() / true_from_strip.scale;
  const double up = true_from_strip.scale * true_from_strip.rotation(2, 2);
  for (std::int32_t j = 0; j < map.height; ++j) {
    for (std::int32_t i = 0; i < map.width; ++i) {
      const double z = heights.at(i, j);
      if (!std::isfinite(z)) continue;
      const Vec3 truly(truth.x0 + i * truth.cell, truth.y0 - j * truth.cell, z);
      const Vec3 place = strip_from_true * (truly - true_from_strip.translation);
      map.at(i, j) = static_cast<float>(up * (merged_height(grid, place.x(), place.y()) - place.z()));
    }
  }
  return map;
}

}  // namespace

HeightScore score_heights(const map::GroundGrid& grid, const AlignedStrip& strip, const world::HeightGrid& truth,
                          const std::vector<Vec3>& centres, double flying_height) {
  HeightScore score;
  score.flying_height = flying_height;
  const double percent = 100 / flying_height;
  Profile profile(centres, flying_height);
  for (std::int32_t j = 0; j < grid.height.height; ++j) {
    for (std::int32_t i = 0; i < grid.height.width; ++i) {
      const double z = grid.height.at(i, j);
      if (!std::isfinite(z)) continue;
      ++score.covered;
      const Vec3 cell(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell, z);
      const Vec3 point = strip.true_from_strip * cell;
      const double error = point.z() - world::height_at(truth, point.x(), point.y());
      if (std::isfinite(error)) {
        score.percent.push_back(static_cast<float>(percent * error));
        profile.add(point, error);
      }
      if (!strip.true_from_metric_strip) continue;
      const Vec3 as_flown = *strip.true_from_metric_strip * cell;
      const double metric_error = as_flown.z() - world::height_at(truth, as_flown.x(), as_flown.y());
      if (std::isfinite(metric_error)) score.metric_percent.push_back(static_cast<float>(percent * metric_error));
    }
  }
  score.error = error_percent(score.percent);
  if (strip.true_from_metric_strip) score.metric = error_percent(score.metric_percent);
  score.profile = profile.points();
  score.error_map = map_errors(grid, strip.true_from_strip, truth);
  return score;
}

}  // namespace ilp::score
