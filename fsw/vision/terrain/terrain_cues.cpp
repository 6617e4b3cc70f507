#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/stereo/normalised_row.hpp"
#include "fsw/vision/terrain/richness_cues.hpp"

namespace ilp {
namespace {

constexpr std::int32_t cell = richness_cell_px;
constexpr std::int32_t min_cells = 64;
constexpr std::int32_t fine_baseline = 2;
constexpr std::int32_t coarse_baseline = 6;
constexpr std::int32_t curvature_baseline = 3;

/// Mean inverse depth (in `height` for now) and viewing direction of every cell that is at least half known.
std::int32_t average_cells(const CameraModel& camera, ImageView<const float> inverse_depth,
                           ImageView<const float> sigma, MaskView mask, RichnessWorkspace& w) {
  const std::int32_t columns = camera.width / cell;
  std::int32_t known_cells = 0;
  for (std::int32_t cy = 0; cy < camera.height / cell; ++cy) {
    normalised_row(camera, cy * cell + cell / 2, w.ray_x.data(), w.ray_y.data());
    for (std::int32_t cx = 0; cx < columns; ++cx) {
      float sum = 0;
      std::int32_t count = 0;
      for (std::int32_t y = cy * cell; y < (cy + 1) * cell; ++y) {
        for (std::int32_t x = cx * cell; x < (cx + 1) * cell; ++x) {
          if (mask.at(x, y) == 0 || !(sigma.at(x, y) > 0)) continue;
          sum += inverse_depth.at(x, y);
          ++count;
        }
      }
      const auto i = static_cast<std::size_t>(cy * columns + cx);
      const auto centre = static_cast<std::size_t>(cx * cell + cell / 2);
      w.has_depth[i] = 2 * count >= cell * cell && sum > 0 ? 1 : 0;
      w.height[i] = w.has_depth[i] != 0 ? sum / static_cast<float>(count) : 0.0F;
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

/// Cells to points in units of the camera's distance from the plane, height above it included.
void raise_cells(std::size_t cells, const Vec3& plane, RichnessWorkspace& w) {
  const auto distance_inverse = static_cast<float>(plane.norm());
  const auto a = static_cast<float>(plane.x());
  const auto b = static_cast<float>(plane.y());
  const auto c = static_cast<float>(plane.z());
  for (std::size_t i = 0; i < cells; ++i) {
    if (w.has_depth[i] == 0) continue;
    const float depth = 1 / w.height[i];
    w.height[i] = 1 - (a * w.x[i] + b * w.y[i] + c) * depth;
    w.x[i] *= depth * distance_inverse;
    w.y[i] *= depth * distance_inverse;
    w.z[i] = depth * distance_inverse;
  }
}

/// Distance of two cells on the plane.
double ground_distance(const RichnessWorkspace& w, std::size_t i, std::size_t j) {
  const auto square = [](float v) { return static_cast<double>(v) * static_cast<double>(v); };
  const double all = square(w.x[i] - w.x[j]) + square(w.y[i] - w.y[j]) + square(w.z[i] - w.z[j]);
  return std::sqrt(std::max(all - square(w.height[i] - w.height[j]), 1e-18));
}

/// The value below which the given share of `values` lies; found in a histogram, to 1/1024 of their range.
double quantile(const float* values, std::size_t count, double share) {
  if (count == 0) return 0;
  const auto [low, high] = std::minmax_element(values, values + count);
  const double base = static_cast<double>(*low);
  const double range = static_cast<double>(*high) - base;
  if (!(range > 0)) return base;
  constexpr std::size_t bins = 1024;
  std::array<std::uint32_t, bins> histogram{};
  for (std::size_t i = 0; i < count; ++i) {
    ++histogram[std::min(bins - 1, static_cast<std::size_t>((static_cast<double>(values[i]) - base) / range * bins))];
  }
  const double wanted = share * static_cast<double>(count);
  double below = 0;
  std::size_t bin = 0;
  while (bin + 1 < bins && below + histogram[bin] < wanted) below += histogram[bin++];
  return base + range * (static_cast<double>(bin) + 0.5) / bins;
}

struct Grid {
  std::int32_t columns, rows;
  /// `use(i, left, right, above, below)` for every known cell with known neighbours `step` cells away.
  template <typename Use>
  void for_each_cross(const RichnessWorkspace& w, std::int32_t step, Use use) const {
    for (std::int32_t y = step; y + step < rows; ++y) {
      for (std::int32_t x = step; x + step < columns; ++x) {
        const auto i = static_cast<std::size_t>(y * columns + x);
        const auto dx = static_cast<std::size_t>(step);
        const auto dy = static_cast<std::size_t>(step * columns);
        if ((w.has_depth[i] & w.has_depth[i - dx] & w.has_depth[i + dx] & w.has_depth[i - dy] & w.has_depth[i + dy]) !=
            0) {
          use(i, i - dx, i + dx, i - dy, i + dy);
        }
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

void slopes(const Grid& grid, RichnessWorkspace& w, RichnessCues& cues) {
  double sum = 0;
  std::size_t count = 0;
  grid.for_each_cross(w, 1, [&](std::size_t, std::size_t l, std::size_t r, std::size_t a, std::size_t b) {
    const double sx = static_cast<double>(w.height[r] - w.height[l]) / ground_distance(w, l, r);
    const double sy = static_cast<double>(w.height[b] - w.height[a]) / ground_distance(w, a, b);
    const double slope = std::sqrt(sx * sx + sy * sy);
    sum += slope;
    w.buffer[count++] = static_cast<float>(slope);
  });
  cues.slope_mean = count == 0 ? 0 : sum / static_cast<double>(count);
  cues.slope_p90 = quantile(w.buffer.data(), count, 0.9);
}

double roughness(const Grid& grid, const RichnessWorkspace& w, std::int32_t step) {
  double sum = 0;
  std::size_t count = 0;
  grid.for_each_cross(w, step, [&](std::size_t i, std::size_t l, std::size_t r, std::size_t a, std::size_t b) {
    const double h = static_cast<double>(w.height[i]);
    const double dx = (h - 0.5 * static_cast<double>(w.height[l] + w.height[r])) / ground_distance(w, l, r);
    const double dy = (h - 0.5 * static_cast<double>(w.height[a] + w.height[b])) / ground_distance(w, a, b);
    sum += 0.5 * (dx * dx + dy * dy);
    ++count;
  });
  return count == 0 ? 0 : std::sqrt(sum / static_cast<double>(count));
}

double curvature(const Grid& grid, RichnessWorkspace& w) {
  std::size_t count = 0;
  grid.for_each_cross(
      w, curvature_baseline, [&](std::size_t i, std::size_t l, std::size_t r, std::size_t a, std::size_t b) {
        const double laplacian =
            static_cast<double>(w.height[l] + w.height[r] + w.height[a] + w.height[b] - 4 * w.height[i]);
        const double baseline = 0.25 * (ground_distance(w, l, r) + ground_distance(w, a, b));
        w.buffer[count++] = static_cast<float>(std::fabs(laplacian) / baseline);
      });
  return quantile(w.buffer.data(), count, 0.95);
}

}  // namespace

void measure_terrain_cues(const CameraModel& camera, ImageView<const float> inverse_depth, ImageView<const float> sigma,
                          MaskView mask, RichnessWorkspace& w, RichnessCues& cues) {
  const Grid grid{camera.width / cell, camera.height / cell};
  const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  cues.has_terrain = false;
  if (average_cells(camera, inverse_depth, sigma, mask, w) < min_cells) return;
  Vec3 plane;
  if (!fit_plane(w, cells, plane)) return;
  raise_cells(cells, plane, w);
  cues.has_terrain = true;
  cues.relief = relief(w, cells);
  slopes(grid, w, cues);
  cues.roughness_fine = roughness(grid, w, fine_baseline);
  cues.roughness_coarse = roughness(grid, w, coarse_baseline);
  cues.curvature = curvature(grid, w);
}

}  // namespace ilp
