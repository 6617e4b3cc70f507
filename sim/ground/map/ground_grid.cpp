#include "sim/ground/map/ground_grid.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <utility>
#include <vector>

#include "sim/host/statistics.hpp"

namespace ilp::map {

GroundGrid::GroundGrid(double x, double y, double side, std::int32_t columns, std::int32_t rows)
    : x0(x),
      y0(y),
      cell(side),
      height(columns, rows, std::numeric_limits<float>::quiet_NaN()),
      sigma(columns, rows, std::numeric_limits<float>::quiet_NaN()),
      ortho(columns, rows),
      count(columns, rows),
      source(columns, rows) {}

namespace {

/// Calls `take(cell, parts)` for every cell whose error of matching is known.
template <typename Take>
void for_each_error(const GroundGrid& grid, const HeightErrors& errors, Take take) {
  if (grid.sigma.empty()) return;
  for (std::int32_t j = 0; j < grid.height.height; ++j) {
    for (std::int32_t i = 0; i < grid.height.width; ++i) {
      const std::size_t cell = grid.height.index(i, j);
      const double z = grid.height.samples[cell], matching = grid.sigma.samples[cell];
      if (!std::isfinite(z) || !std::isfinite(matching)) continue;
      const Vec3 point(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell, z);
      take(cell, errors.parts(point, grid.source.samples[cell], matching));
    }
  }
}

}  // namespace

host::Raster<float> whole_sigma_of(const GroundGrid& grid, const HeightErrors& errors) {
  host::Raster<float> whole(grid.height.width, grid.height.height, std::numeric_limits<float>::quiet_NaN());
  for_each_error(grid, errors, [&](std::size_t cell, const HeightErrorParts& parts) {
    whole.samples[cell] = static_cast<float>(parts.whole());
  });
  return whole;
}

HeightErrorParts usual_parts(const GroundGrid& grid, const HeightErrors& errors) {
  std::vector<double> matching, poses, scale, tilt, place;
  for_each_error(grid, errors, [&](std::size_t, const HeightErrorParts& parts) {
    matching.push_back(parts.matching);
    poses.push_back(parts.poses);
    scale.push_back(parts.scale);
    tilt.push_back(parts.tilt);
    place.push_back(parts.place);
  });
  if (matching.empty()) return {};
  return {host::median(std::move(matching)), host::median(std::move(poses)), host::median(std::move(scale)),
          host::median(std::move(tilt)), host::median(std::move(place))};
}

Plane mean_plane(const GroundGrid& grid) {
  const double middle_x = grid.x0 + 0.5 * grid.cell * grid.height.width;
  const double middle_y = grid.y0 - 0.5 * grid.cell * grid.height.height;
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::int32_t j = 0; j < grid.height.height; ++j) {
    for (std::int32_t i = 0; i < grid.height.width; ++i) {
      const double z = grid.height.at(i, j);
      if (!std::isfinite(z)) continue;
      const Vec3 row(grid.x0 + i * grid.cell - middle_x, grid.y0 - j * grid.cell - middle_y, 1);
      normal += row * row.transpose();
      right += row * z;
    }
  }
  const Vec3 p = normal.ldlt().solve(right);
  if (!p.allFinite()) return {};
  return {p.x(), p.y(), p.z() - p.x() * middle_x - p.y() * middle_y};
}

}  // namespace ilp::map
