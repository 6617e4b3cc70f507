#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/vector_width.hpp"
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
    normalised_row(camera, cy * cell + cell / 2, 0, camera.width, w.ray_x.data(), w.ray_y.data());
    for (std::int32_t cx = 0; cx < columns; ++cx) {
      float sum = 0;
      float sigma_sum = 0;
      std::int32_t count = 0;
      for (std::int32_t y = cy * cell; y < (cy + 1) * cell; ++y) {
        // Most of an image has been seen before.
        std::uint32_t row_of_cell;
        static_assert(cell == sizeof row_of_cell);
        std::memcpy(&row_of_cell, mask.row(y) + std::ptrdiff_t{cx} * cell, sizeof row_of_cell);
        if (row_of_cell == 0) continue;
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
      w.raised[i].height = w.has_depth[i] != 0 ? sum / static_cast<float>(count) : 0.0F;
      w.raised[i].sigma = w.has_depth[i] != 0 ? sigma_sum / static_cast<float>(count) : 0.0F;
      w.raised[i].x = static_cast<float>(w.ray_x[centre]);
      w.raised[i].y = static_cast<float>(w.ray_y[centre]);
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
    const Vec3 ray(static_cast<double>(w.raised[i].x), static_cast<double>(w.raised[i].y), 1);
    normal += ray * ray.transpose();
    right += static_cast<double>(w.raised[i].height) * ray;
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
    const double inverse_depth = static_cast<double>(w.raised[i].height);
    const Vec3 ray(static_cast<double>(w.raised[i].x), static_cast<double>(w.raised[i].y), 1);
    const double reach = plane.dot(ray) / inverse_depth;
    const double scale = inverse_distance / inverse_depth;
    w.raised[i].height = static_cast<float>(1 - reach);
    w.raised[i].sigma = static_cast<float>(std::fabs(reach) * static_cast<double>(w.raised[i].sigma) / inverse_depth);
    w.raised[i].x = static_cast<float>(along.dot(ray) * scale);
    w.raised[i].y = static_cast<float>(across.dot(ray) * scale);
  }
}

using Four [[gnu::vector_size(32)]] = double;

/// Sums over known cells, relative to a nearby place.
struct Moments {
  double n = 0;
  Four first{};   ///< x, y, h, sigma
  Four second{};  ///< xx, xy, yy, hh
  Four third{};   ///< xh, yh, h sigma, sigma^2

  void add(const Four& at) {
    n += 1;
    first += at;
    second += __builtin_shufflevector(at, at, 0, 0, 1, 2) * __builtin_shufflevector(at, at, 0, 1, 1, 2);
    third += at * __builtin_shufflevector(at, at, 2, 2, 3, 3);
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

/// Sums over the known cells of a window and of its core, relative to its middle.
struct WindowSums {
  Moments all, core;
};

void sum_window(const RichnessWorkspace& w, std::int32_t columns, const Window& window, const Four& middle,
                WindowSums& sums) {
  const std::int32_t border = (window.size - window.core) / 2, core_end = window.size - border;
  Moments all;
  Four core{};
  double core_n = 0;
  for (std::int32_t dy = 0; dy < window.size; ++dy) {
    const std::int32_t at_row = (window.y + dy) * columns + window.x;
    const auto row = static_cast<std::size_t>(at_row);
    const bool core_row = dy >= border && dy < core_end;
    for (std::int32_t dx = 0; dx < window.size; ++dx) {
      const std::size_t i = row + static_cast<std::size_t>(dx);
      if (w.has_depth[i] == 0) continue;
      const RichnessWorkspace::Raised& cell_at = w.raised[i];
      const Four at = Four{static_cast<double>(cell_at.x), static_cast<double>(cell_at.y),
                           static_cast<double>(cell_at.height), static_cast<double>(cell_at.sigma)} -
                      middle;
      all.add(at);
      if (!core_row || dx < border || dx >= core_end) continue;
      core_n += 1;
      core += at;
    }
  }
  sums.all = all;
  sums.core.n = core_n;
  sums.core.first = core;
}

/// Returns false if less than half of the window is known, or its known cells are on a line.
bool fit_window(const RichnessWorkspace& w, std::int32_t columns, const Window& window, WindowFit& fit) {
  const std::int32_t size = window.size;
  const std::int32_t at_middle = (window.y + size / 2) * columns + window.x + size / 2;
  const auto middle = static_cast<std::size_t>(at_middle);
  if (w.has_depth[middle] == 0) return false;
  WindowSums sums;
  sum_window(w, columns, window,
             Four{static_cast<double>(w.raised[middle].x), static_cast<double>(w.raised[middle].y), 0, 0}, sums);
  const Moments &all = sums.all, &core = sums.core;
  const double n = all.n, x = all.first[0], y = all.first[1], h = all.first[2];
  if (2 * n < size * size) return false;
  const double cxx = all.second[0] - x * x / n;
  const double cxy = all.second[1] - x * y / n;
  const double cyy = all.second[2] - y * y / n;
  const double cxh = all.third[0] - x * h / n;
  const double cyh = all.third[1] - y * h / n;
  const double chh = all.second[3] - h * h / n;
  const double determinant = cxx * cyy - cxy * cxy;
  if (!(determinant > 1e-3 * (cxx + cyy) * (cxx + cyy))) return false;
  const double slope_x = (cyy * cxh - cxy * cyh) / determinant;
  const double slope_y = (cxx * cyh - cxy * cxh) / determinant;
  // A square of side s has the variance s^2 / 12 in both directions.
  fit.side = std::sqrt(12 * std::sqrt(determinant) / n);
  fit.slope = std::sqrt(slope_x * slope_x + slope_y * slope_y);
  const double left_over = (chh - slope_x * cxh - slope_y * cyh) / (n - 3);
  fit.roughness = std::sqrt(std::max(0.0, left_over - all.third[3] / n)) / fit.side;
  fit.curvature = 0;
  const double rest_n = n - core.n;
  if (core.n > 0 && rest_n > 0) {
    const double dx = core.first[0] / core.n - (x - core.first[0]) / rest_n;
    const double dy = core.first[1] / core.n - (y - core.first[1]) / rest_n;
    const double dh = core.first[2] / core.n - (h - core.first[2]) / rest_n;
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
        bool fitted = false;
        with_widest_vectors([&] { fitted = fit_window(w, columns, {x, y, size, core}, fit); });
        if (fitted) use(fit);
      }
    }
  }
};

double relief(RichnessWorkspace& w, std::size_t cells) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    if (w.has_depth[i] != 0) w.buffer[count++] = w.raised[i].height;
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
