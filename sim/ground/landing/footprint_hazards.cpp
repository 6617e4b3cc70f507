#include "sim/ground/landing/footprint_hazards.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "sim/host/parallel.hpp"
#include "sim/host/statistics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::landing {
namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
constexpr double least_cells_across = 5, centres_across = 16;

/// Half the width of each row of the circle, in cells.
struct Circle {
  std::int32_t radius = 0;
  std::vector<std::int32_t> half;  ///< of row -radius + k
  std::size_t cells = 0;

  explicit Circle(double r) : radius(static_cast<std::int32_t>(std::floor(r))) {
    for (std::int32_t y = -radius; y <= radius; ++y) {
      half.push_back(static_cast<std::int32_t>(std::floor(std::sqrt(r * r - static_cast<double>(y) * y))));
      cells += static_cast<std::size_t>(2 * half.back() + 1);
    }
  }
};

/// Sums over the heights of a circle, coordinates in cells from its centre, y upwards.
struct PlaneSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, z = 0, xz = 0, yz = 0, variance = 0;
};

struct CellPlane {
  double a = 0, b = 0, c = 0;  ///< z = a x + b y + c
  double xx = 0, yy = 0;       ///< mean squares of the coordinates about their means
};

CellPlane solve(const PlaneSums& s) {
  const double mx = s.x / s.n, my = s.y / s.n, mz = s.z / s.n;
  const double xx = s.xx / s.n - mx * mx, yy = s.yy / s.n - my * my, xy = s.xy / s.n - mx * my;
  const double xz = s.xz / s.n - mx * mz, yz = s.yz / s.n - my * mz, det = xx * yy - xy * xy;
  CellPlane plane;
  plane.a = (xz * yy - yz * xy) / det;
  plane.b = (yz * xx - xz * xy) / det;
  plane.c = mz - plane.a * mx - plane.b * my;
  plane.xx = xx;
  plane.yy = yy;
  return plane;
}

double median_sigma(const map::GroundGrid& grid) {
  std::vector<double> known;
  for (const float sigma : grid.sigma.samples) {
    if (std::isfinite(sigma)) known.push_back(sigma);
  }
  if (known.empty()) throw std::runtime_error("the heights of the map have no known errors");
  return host::median(std::move(known));
}

class Footprints {
 public:
  Footprints(const map::GroundGrid& grid, const Footprint& footprint)
      : grid_(grid),
        metres_(footprint.metres_per_unit),
        circle_(footprint.diameter_m / (2 * footprint.metres_per_unit * grid.cell)),
        least_(footprint.least_cover * static_cast<double>(circle_.cells)),
        usual_sigma_(median_sigma(grid)) {}

  void at(std::int32_t column, std::int32_t row, std::size_t to, FootprintHazards& out) const {
    if (!std::isfinite(grid_.height.at(column, row))) return;
    const double origin = grid_.height.at(column, row);
    PlaneSums s;
    for_each(column, row, [&](double x, double y, std::size_t i) {
      const double z = grid_.height.samples[i] - origin;
      const double sigma = std::isfinite(grid_.sigma.samples[i]) ? grid_.sigma.samples[i] : usual_sigma_;
      s.n += 1;
      s.x += x;
      s.y += y;
      s.xx += x * x;
      s.xy += x * y;
      s.yy += y * y;
      s.z += z;
      s.xz += x * z;
      s.yz += y * z;
      s.variance += sigma * sigma;
    });
    if (s.n < least_) return;
    const CellPlane plane = solve(s);
    double low = 1e30, high = -1e30, squares = 0;
    for_each(column, row, [&](double x, double y, std::size_t i) {
      const double off = grid_.height.samples[i] - origin - plane.a * x - plane.b * y - plane.c;
      low = std::min(low, off);
      high = std::max(high, off);
      squares += off * off;
    });
    const double variance = s.variance / s.n, independent = std::max(3.0, s.n / cells_per_error);
    out.gradient_x.samples[to] = static_cast<float>(plane.a / grid_.cell);
    out.gradient_y.samples[to] = static_cast<float>(plane.b / grid_.cell);
    out.gradient_sigma.samples[to] =
        static_cast<float>(std::sqrt(variance / (independent * std::min(plane.xx, plane.yy))) / grid_.cell);
    out.roughness_m.samples[to] = static_cast<float>(metres_ * std::sqrt(squares / s.n));
    out.step_m.samples[to] = static_cast<float>(metres_ * (high - low));
    out.sigma_m.samples[to] = static_cast<float>(metres_ * std::sqrt(variance));
  }

 private:
  template <typename Visit>
  void for_each(std::int32_t column, std::int32_t row, Visit visit) const {
    for (std::int32_t dy = -circle_.radius; dy <= circle_.radius; ++dy) {
      const std::int32_t y = row + dy;
      if (y < 0 || y >= grid_.height.height) continue;
      const std::int32_t half = circle_.half[static_cast<std::size_t>(dy + circle_.radius)];
      const std::int32_t first = std::max(0, column - half), last = std::min(grid_.height.width - 1, column + half);
      for (std::int32_t x = first; x <= last; ++x) {
        const std::size_t i = grid_.height.index(x, y);
        if (std::isfinite(grid_.height.samples[i])) visit(static_cast<double>(x - column), static_cast<double>(-dy), i);
      }
    }
  }

  const map::GroundGrid& grid_;
  double metres_;
  Circle circle_;
  double least_;
  double usual_sigma_;
};

}  // namespace

FootprintHazards footprint_hazards(const map::GroundGrid& grid, const Footprint& footprint) {
  const double cell_m = grid.cell * footprint.metres_per_unit, across = footprint.diameter_m / cell_m;
  if (!(across >= least_cells_across)) {
    throw std::runtime_error("a footprint of " + host::brief(footprint.diameter_m) + " m is too small for cells of " +
                             host::brief(cell_m) + " m: name " + host::brief(least_cells_across * cell_m) +
                             " m or more");
  }
  FootprintHazards out;
  out.stride = std::max(1, static_cast<std::int32_t>(std::floor(across / centres_across)));
  const std::int32_t columns = (grid.height.width + out.stride - 1) / out.stride,
                     rows = (grid.height.height + out.stride - 1) / out.stride;
  out.geometry = {grid.x0, grid.y0, grid.cell * out.stride, columns, rows};
  for (host::Raster<float>* raster :
       {&out.gradient_x, &out.gradient_y, &out.gradient_sigma, &out.roughness_m, &out.step_m, &out.sigma_m}) {
    *raster = host::Raster<float>(columns, rows, nothing);
  }
  const Footprints footprints(grid, footprint);
  host::for_each_parallel(static_cast<std::size_t>(rows), [&](std::size_t row) {
    for (std::int32_t column = 0; column < columns; ++column) {
      const auto y = static_cast<std::int32_t>(row);
      footprints.at(column * out.stride, y * out.stride, out.step_m.index(column, y), out);
    }
  });
  return out;
}

}  // namespace ilp::landing
