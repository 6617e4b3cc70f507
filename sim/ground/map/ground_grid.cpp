#include "sim/ground/map/ground_grid.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Dense>

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
