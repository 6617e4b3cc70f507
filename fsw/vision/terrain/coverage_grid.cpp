#include "fsw/vision/terrain/coverage_grid.hpp"

#include <cmath>

#include "fsw/vision/stereo/depth/normalised_row.hpp"

namespace ilp {

Status clear_grid(double x, double y, double cell, CoverageGrid& grid) {
  if (!(std::isfinite(cell) && cell > 0 && std::isfinite(x) && std::isfinite(y)))
    return {StatusCode::invalid_argument, 1};
  grid.origin_x = x - 0.5 * coverage_grid_side * cell;
  grid.origin_y = y - 0.5 * coverage_grid_side * cell;
  grid.cell = cell;
  grid.images.fill(0);
  return {};
}

Status add_to_grid(const CameraModel& camera, const RigidTransform& cam_from_world,
                   ImageView<const float> inverse_depth, ImageView<const float> sigma, std::int32_t stride,
                   CoverageGridWorkspace& w, CoverageGrid& grid, GridUpdate& update) {
  update = {};
  if (inverse_depth.width != camera.width || inverse_depth.height != camera.height || sigma.width != camera.width ||
      sigma.height != camera.height || camera.width > limits::max_image_width) {
    return {StatusCode::invalid_argument, 1, sigma.width};
  }
  if (stride < 1) return {StatusCode::invalid_argument, 2, stride};
  if (!(grid.cell > 0)) return {StatusCode::invalid_argument, 3};
  const Mat3 world_from_cam = cam_from_world.rotation.transpose();
  const Vec3 centre = -(world_from_cam * cam_from_world.translation);
  const double per_cell = 1 / grid.cell;
  w.seen.fill(0);
  for (std::int32_t y = 0; y < camera.height; y += stride) {
    normalised_row(camera, y, w.ray_x.data(), w.ray_y.data());
    for (std::int32_t x = 0; x < camera.width; x += stride) {
      const double inverse = static_cast<double>(inverse_depth.at(x, y));
      if (!(sigma.at(x, y) > 0) || !(inverse > 0)) continue;
      const auto k = static_cast<std::size_t>(x);
      const Vec3 ground = centre + world_from_cam * Vec3(w.ray_x[k], w.ray_y[k], 1) / inverse;
      const double column = std::floor((ground.x() - grid.origin_x) * per_cell);
      const double row = std::floor((ground.y() - grid.origin_y) * per_cell);
      if (!(column >= 0 && row >= 0 && column < coverage_grid_side && row < coverage_grid_side)) {
        ++update.outside;
        continue;
      }
      w.seen[static_cast<std::size_t>(row) * coverage_grid_side + static_cast<std::size_t>(column)] = 1;
    }
  }
  for (std::size_t i = 0; i < w.seen.size(); ++i) {
    if (w.seen[i] == 0) continue;
    ++update.cells;
    update.new_cells += grid.images[i] == 0 ? 1 : 0;
    if (grid.images[i] < 255) ++grid.images[i];
  }
  return {};
}

}  // namespace ilp
