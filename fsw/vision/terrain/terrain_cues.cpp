#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/stereo/depth/normalised_row.hpp"
#include "fsw/vision/terrain/richness_cues.hpp"

namespace ilp {
namespace {

constexpr std::int32_t min_cells = 64;

/// Sides of the windows in which a plane is fitted, and their spacing, in cells.
constexpr std::int32_t fine_window = 5;
constexpr std::int32_t fine_stride = 2;
constexpr std::int32_t middle_window = 9;
constexpr std::int32_t middle_stride = 2;
constexpr std::int32_t middle_core = 5;  // of the middle window, for the curvature
constexpr std::int32_t coarse_window = 13;
constexpr std::int32_t coarse_stride = 3;

constexpr double steepest_share = 0.98;
constexpr double roughest_share = 0.98;

/// Mean inverse depth (in `height` for now), its error and the viewing direction of every cell that is at least half
/// known.
std::int32_t average_cells(const CameraModel& camera, ImageView<const float> inverse_depth,
                           ImageView<const float> sigma, MaskView mask, RichnessWorkspace& w) {
  const std::int32_t columns = camera.width / cell;
  std::int32_t known_cells = 0;
  for (std::int32_t cy = 0; cy < camera.height / cell; ++cy) {
    normalised_row(camera, cy * cell + cell / 2, w.ray_x.data(), w.ray_y.data());
    for (std::int32_t cx = 0; cx < columns; ++cx) {
      float sum = 0;
      float sigma_sum = 0;
      std::int32_t count = 0;
      for (std::int32_t y = cy * cell; y < (cy + 1) * cell; ++y) {
        for (std::int32_t x = cx * cell; x < (cx + 1) * cell; ++x) {
          if (mask.at(x, y) == 0 || !(sigma.at(x, y) > 0)) continue;
          sum += inverse_depth.at(x, y);
          sigma_sum += sigma.at(x, y);
          ++count;
        }
      }
      const std::int32_t at_cell = cy * columns + cx, at_centre = cx * cell + cell / 2;
      const auto i = static_cast<std::size_t>(at_cell);
      const auto centre = static_cast<std::size_t>(at_centre);
      w.has_depth[i] = 2 * count >= cell * cell && sum > 0 ? 1 : 0;
      w.height[i] = w.has_depth[i] != 0 ? sum / static_cast<float>(count) : 0.0F;
      w.height_sigma[i] = w.has_depth[i] != 0 ? sigma_sum / static_cast<float>(count) : 0.0F;
      w.x[i] = static_cast<float>(w.ray_x[centre]);
      w.y[i] = static_cast<float>(w.ray_y[centre]);
      known_cells += w.has_depth[i];
    }
  }
  return known_cells;
}

/// A plane n.X = d has inverse depth (n/d).(x, y, 1), so the best plane is a linear fit. False when the cells lie on a
/// line.
bool fit_plane(const RichnessWorkspace& w, std::size_t cells, Vec3& plane) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < cells; ++i) {
    if (w.has_depth[i] == 0) continue;
    const Vec3 ray(static_cast<double>(w.x[i]), static_cast<double>(w.y[i]), 1);
    normal += ray * ray.transpose();
    right += static_cast<double>(w.height[i]) * ray;
  }
  const Vec3 c0 = normal.col(0);
  const Vec3 c1 = normal.col(1);
  const Vec3 c2 = normal.col(2);
  const double determinant = c0.dot(c1.cross(c2));
  const double scale = normal.trace() * normal.trace() * normal.trace();
  if (!(determinant > 1e-12 * scale)) return false;
  plane = Vec3(right.dot(c1.cross(c2)), c0.dot(right.cross(c2)), c0.dot(c1.cross(right))) / determinant;
  return plane.squaredNorm() > 0;
}

/// Converts cells to the height above the plane, its error, and coordinates on the plane, in units of the camera's
/// distance from it.
void raise_cells(std::size_t cells, const Vec3& plane, RichnessWorkspace& w) {
  const double inverse_distance = plane.norm();
  const Vec3 up = plane / inverse_distance;
  // Any two directions on the plane.
  const Vec3 least = std::fabs(up.x()) < std::fabs(up.y()) ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 along = least.cross(up).normalized();
  const Vec3 across = up.cross(along);
  for (std::size_t i = 0; i < cells; ++i) {
    if (w.has_depth[i] == 0) continue;
    const double inverse_depth = static_cast<double>(w.height[i]);
    const Vec3 ray(static_cast<double>(w.x[i]), static_cast<double>(w.y[i]), 1);
    const double reach = plane.dot(ray) / inverse_depth;
    const double scale = inverse_distance / inverse_depth;
    w.height[i] = static_cast<float>(1 - reach);
    w.height_sigma[i] = static_cast<float>(std::fabs(reach) * static_cast<double>(w.height_sigma[i]) / inverse_depth);
    w.x[i] = static_cast<float>(along.dot(ray) * scale);
    w.y[i] = static_cast<float>(across.dot(ray) * scale);
  }
}

/// Sums over known cells, relative to a nearby place.
struct Moments {
  double n = 0, x = 0, y = 0, h = 0, xx = 0, xy = 0, yy = 0, xh = 0, yh = 0, hh = 0, noise = 0;

  void add(double at_x, double at_y, double at_h, double sigma) {
    n += 1;
    x += at_x;
    y += at_y;
    h += at_h;
    xx += at_x * at_x;
    xy += at_x * at_y;
    yy += at_y * at_y;
    xh += at_x * at_h;
    yh += at_y * at_h;
    hh += at_h * at_h;
    noise += sigma * sigma;
  }
};

/// The result of a plane through the heights of a window. `side` is that of the square on the ground with the same
/// spread as its known cells.
struct WindowFit {
  double side = 0;
  double slope = 0;      ///< tangent, against the plane of the whole part
  double roughness = 0;  ///< rms of what the plane leaves, noise taken off, / side
  double curvature = 0;  ///< |mean of the core - mean of the rest| / side, both above the plane
};

struct Window {
  std::int32_t x, y, size, core;
};

/// Returns false if less than half of the window is known, or its known cells are on a line.
bool fit_window(const RichnessWorkspace& w, std::int32_t columns, const Window& window, WindowFit& fit) {
  const std::int32_t size = window.size;
  const std::int32_t border = (size - window.core) / 2;
  const std::int32_t at_middle = (window.y + size / 2) * columns + window.x + size / 2;
  const auto middle = static_cast<std::size_t>(at_middle);
  if (w.has_depth[middle] == 0) return false;
  const double x0 = static_cast<double>(w.x[middle]);
  const double y0 = static_cast<double>(w.y[middle]);
  Moments all;
  double core_n = 0;
  double core_x = 0;
  double core_y = 0;
  double core_h = 0;
  for (std::int32_t dy = 0; dy < size; ++dy) {
    const std::int32_t at_row = (window.y + dy) * columns + window.x;
    const auto row = static_cast<std::size_t>(at_row);
    const bool core_row = dy >= border && dy < size - border;
    for (std::int32_t dx = 0; dx < size; ++dx) {
      const std::size_t i = row + static_cast<std::size_t>(dx);
      if (w.has_depth[i] == 0) continue;
      const double x = static_cast<double>(w.x[i]) - x0;
      const double y = static_cast<double>(w.y[i]) - y0;
      const double h = static_cast<double>(w.height[i]);
      all.add(x, y, h, static_cast<double>(w.height_sigma[i]));
      if (core_row && dx >= border && dx < size - border) {
        core_n += 1;
        core_x += x;
        core_y += y;
        core_h += h;
      }
    }
  }
  if (2 * all.n < size * size) return false;
  const double cxx = all.xx - all.x * all.x / all.n;
  const double cxy = all.xy - all.x * all.y / all.n;
  const double cyy = all.yy - all.y * all.y / all.n;
  const double cxh = all.xh - all.x * all.h / all.n;
  const double cyh = all.yh - all.y * all.h / all.n;
  const double chh = all.hh - all.h * all.h / all.n;
  const double determinant = cxx * cyy - cxy * cxy;
  if (!(determinant > 1e-3 * (cxx + cyy) * (cxx + cyy))) return false;
  const double slope_x = (cyy * cxh - cxy * cyh) / determinant;
  const double slope_y = (cxx * cyh - cxy * cxh) / determinant;
  // A square of side s has the variance s^2 / 12 in both directions.
  fit.side = std::sqrt(12 * std::sqrt(determinant) / all.n);
  fit.slope = std::sqrt(slope_x * slope_x + slope_y * slope_y);
  const double left_over = (chh - slope_x * cxh - slope_y * cyh) / (all.n - 3);
  fit.roughness = std::sqrt(std::max(0.0, left_over - all.noise / all.n)) / fit.side;
  fit.curvature = 0;
  const double rest_n = all.n - core_n;
  if (core_n > 0 && rest_n > 0) {
    const double dx = core_x / core_n - (all.x - core_x) / rest_n;
    const double dy = core_y / core_n - (all.y - core_y) / rest_n;
    const double dh = core_h / core_n - (all.h - core_h) / rest_n;
    fit.curvature = std::fabs(dh - slope_x * dx - slope_y * dy) / fit.side;
  }
  return true;
}

struct Grid {
  std::int32_t columns, rows;

  /// Calls `use(fit)` for windows of `size` cells, `stride` apart, that could be fitted.
  template <typename Use>
  void for_each_window(const RichnessWorkspace& w, std::int32_t size, std::int32_t core, std::int32_t stride,
                       Use use) const {
    for (std::int32_t y = 0; y + size <= rows; y += stride) {
      for (std::int32_t x = 0; x + size <= columns; x += stride) {
        WindowFit fit;
        if (fit_window(w, columns, {x, y, size, core}, fit)) use(fit);
      }
    }
  }
};

double relief(RichnessWorkspace& w, std::size_t cells) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    if (w.has_depth[i] != 0) w.buffer[count++] = w.height[i];
  }
  return quantile(w.buffer.data(), count, 0.95) - quantile(w.buffer.data(), count, 0.05);
}

double roughness(const Grid& grid, RichnessWorkspace& w, std::int32_t size, std::int32_t stride) {
  std::size_t count = 0;
  grid.for_each_window(w, size, size, stride,
                       [&](const WindowFit& fit) { w.buffer[count++] = static_cast<float>(fit.roughness); });
  return quantile(w.buffer.data(), count, roughest_share);
}

void slopes_and_curvature(const Grid& grid, RichnessWorkspace& w, RichnessCues& cues) {
  std::size_t count = 0;
  float* slopes = w.buffer.data();
  float* curvatures = w.buffer.data() + max_richness_cells;
  grid.for_each_window(w, middle_window, middle_core, middle_stride, [&](const WindowFit& fit) {
    slopes[count] = static_cast<float>(fit.slope);
    curvatures[count++] = static_cast<float>(fit.curvature);
  });
  cues.slope_steep = quantile(slopes, count, steepest_share);
  cues.slope_excess = cues.slope_steep - quantile(slopes, count, 0.5);
  cues.curvature = quantile(curvatures, count, roughest_share);
}

/// False where there is too little depth.
bool measure_heights(const CameraModel& camera, ImageView<const float> inverse_depth, ImageView<const float> sigma,
                     MaskView mask, std::size_t cells, RichnessWorkspace& w) {
  if (average_cells(camera, inverse_depth, sigma, mask, w) < min_cells) return false;
  Vec3 plane;
  if (!fit_plane(w, cells, plane)) return false;
  raise_cells(cells, plane, w);
  return true;
}

}  // namespace

void measure_terrain_cues(std::int32_t part, const CameraModel& camera, ImageView<const float> inverse_depth,
                          ImageView<const float> sigma, MaskView mask, RichnessWorkspace& w, RichnessCues& cues) {
  const Grid grid{camera.width / cell, camera.height / cell};
  const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  if (part == 0) {
    cues.has_terrain = measure_heights(camera, inverse_depth, sigma, mask, cells, w);
    if (cues.has_terrain) cues.relief = relief(w, cells);
  } else if (!cues.has_terrain) {
    return;
  } else if (part == 1) {
    slopes_and_curvature(grid, w, cues);
  } else {
    cues.roughness_fine = roughness(grid, w, fine_window, fine_stride);
    cues.roughness_coarse = roughness(grid, w, coarse_window, coarse_stride);
  }
}

}  // namespace ilp
