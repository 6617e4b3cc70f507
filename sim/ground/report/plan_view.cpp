#include "sim/ground/report/plan_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/host/statistics.hpp"

namespace ilp::report {
namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

struct Box {
  double along_low = std::numeric_limits<double>::max(), along_high = std::numeric_limits<double>::lowest();
  double across_low = along_low, across_high = along_high;

  void include(double along, double across) {
    along_low = std::min(along_low, along);
    along_high = std::max(along_high, along);
    across_low = std::min(across_low, across);
    across_high = std::max(across_high, across);
  }
};

void include_grid(const map::GroundGrid& grid, const PlanView& view, Box& box) {
  for (std::int32_t j = 0; j < grid.count.height; ++j) {
    for (std::int32_t i = 0; i < grid.count.width; ++i) {
      if (grid.count.at(i, j) == 0) continue;
      const double x = grid.x0 + i * grid.cell, y = grid.y0 - j * grid.cell;
      box.include(view.along(x, y), view.across(x, y));
    }
  }
}

// Mean of the cells under one picture pixel.
struct CellMean {
  double height = 0, grey = 0;
  int cells = 0;
};

/// Of what was measured, else of laid ground.
struct PixelMean {
  CellMean measured, laid;
};

PixelMean mean_around(const map::GroundGrid& grid, const map::Plane& plane, double x, double y, std::int32_t radius) {
  PixelMean mean;
  const double column = std::floor(grid.column_of(x) + 0.5), row = std::floor(grid.row_of(y) + 0.5);
  if (std::fabs(column) > 1e8 || std::fabs(row) > 1e8) return mean;
  const auto ci = static_cast<std::int32_t>(column), cj = static_cast<std::int32_t>(row);
  for (std::int32_t j = cj - radius; j <= cj + radius; ++j) {
    for (std::int32_t i = ci - radius; i <= ci + radius; ++i) {
      if (!grid.height.contains(i, j)) continue;
      const bool measured = grid.count.at(i, j) != 0;
      if (!measured && (grid.laid.grey.empty() || grid.laid.grey.at(i, j) == 0)) continue;
      CellMean& part = measured ? mean.measured : mean.laid;
      const float z = measured ? grid.height.at(i, j) : grid.laid.height.at(i, j);
      part.height += z - plane.at(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell);
      part.grey += measured ? grid.ortho.at(i, j) : grid.laid.grey.at(i, j);
      ++part.cells;
    }
  }
  return mean;
}

void close_small_holes(ViewSurface& surface) {
  const host::Raster<float> relief = surface.relief;
  const host::Raster<std::uint8_t> ortho = surface.ortho;
  for (std::int32_t y = 2; y + 2 < relief.height; ++y) {
    for (std::int32_t x = 2; x + 2 < relief.width; ++x) {
      if (std::isfinite(relief.at(x, y)) || std::isfinite(surface.laid.at(x, y))) continue;
      double height = 0, grey = 0;
      int cells = 0;
      for (std::int32_t j = y - 2; j <= y + 2; ++j) {
        for (std::int32_t i = x - 2; i <= x + 2; ++i) {
          if (!std::isfinite(relief.at(i, j))) continue;
          height += relief.at(i, j);
          grey += ortho.at(i, j);
          ++cells;
        }
      }
      constexpr int surrounded = 12;
      if (cells < surrounded) continue;
      surface.relief.at(x, y) = static_cast<float>(height / cells);
      surface.ortho.at(x, y) = static_cast<std::uint8_t>(grey / cells + 0.5);
    }
  }
}

struct Gradient {
  double along = 0, down = 0;
};

Gradient gradient_at(const host::Raster<float>& relief, std::int32_t x, std::int32_t y, double unit_per_px) {
  const auto value = [&](std::int32_t i, std::int32_t j) {
    const float v = relief.contains(i, j) ? relief.at(i, j) : nothing;
    return std::isfinite(v) ? v : relief.at(x, y);
  };
  return {(value(x + 1, y) - value(x - 1, y)) / (2 * unit_per_px),
          (value(x, y + 1) - value(x, y - 1)) / (2 * unit_per_px)};
}

// Flat ground would be a grey sheet: heights are exaggerated until the steeper tenth of the slopes shows.
double shading_exaggeration(const host::Raster<float>& relief, double unit_per_px) {
  std::vector<double> slopes;
  for (std::int32_t y = 1; y + 1 < relief.height; y += 3) {
    for (std::int32_t x = 1; x + 1 < relief.width; x += 3) {
      if (!std::isfinite(relief.at(x, y))) continue;
      const Gradient g = gradient_at(relief, x, y, unit_per_px);
      slopes.push_back(std::hypot(g.along, g.down));
    }
  }
  const double steep = host::percentile(std::move(slopes), 0.9);
  return steep > 0 ? std::clamp(0.6 / steep, 1.0, 8.0) : 1.0;
}

void add_shade(ViewSurface& surface, double unit_per_px) {
  const host::Raster<float>& relief = surface.relief;
  surface.exaggeration = shading_exaggeration(relief, unit_per_px);
  surface.shade = host::Raster<float>(relief.width, relief.height);
  constexpr double light[] = {-0.5, -0.5, 0.70710678};  // from the upper left, 45 degrees high
  for (std::int32_t y = 0; y < relief.height; ++y) {
    for (std::int32_t x = 0; x < relief.width; ++x) {
      if (!std::isfinite(relief.at(x, y))) continue;
      const Gradient g = gradient_at(relief, x, y, unit_per_px);
      const double nx = -g.along * surface.exaggeration, ny = -g.down * surface.exaggeration;
      const double cosine = (nx * light[0] + ny * light[1] + light[2]) / std::sqrt(nx * nx + ny * ny + 1);
      surface.shade.at(x, y) = static_cast<float>(std::clamp(cosine, 0.0, 1.0));
    }
  }
}

// Dark ground would be a dark page: the central 98 % of the grey values fill the scale.
void stretch_contrast(ViewSurface& surface) {
  std::vector<double> greys;
  for (std::size_t i = 0; i < surface.ortho.samples.size(); i += 3) {
    if (std::isfinite(surface.relief.samples[i])) greys.push_back(surface.ortho.samples[i]);
  }
  if (greys.empty()) return;
  const double low = host::percentile(greys, 0.01), high = std::max(host::percentile(greys, 0.99), low + 16);
  for (std::uint8_t& g : surface.ortho.samples) {
    g = static_cast<std::uint8_t>(std::clamp(20 + 220 * (g - low) / (high - low), 0.0, 255.0));
  }
}

std::uint8_t scaled(std::uint8_t value, double factor) {
  return static_cast<std::uint8_t>(std::clamp(value * factor + 0.5, 0.0, 255.0));
}

/// Every fourth diagonal of laid ground has the colour of the hatch.
host::Rgba hatched(std::uint8_t grey, std::int32_t x, std::int32_t y) {
  constexpr std::int32_t apart = 4;
  return (x + y) % apart == 0 ? laid_hatch : host::Rgba{grey, grey, grey, 255};
}

}  // namespace

PlanView make_plan_view(const map::GroundGrid* grid, const std::vector<Vec3>& track, std::int32_t max_width,
                        std::int32_t max_height) {
  PlanView view;
  if (track.size() >= 2) {
    const Vec3 direction = track.back() - track.front();
    const double length = std::hypot(direction.x(), direction.y());
    if (length > 0) {
      view.cosine = direction.x() / length;
      view.sine = direction.y() / length;
    }
  }
  Box box;
  if (grid != nullptr) include_grid(*grid, view, box);
  for (const Vec3& c : track) box.include(view.along(c.x(), c.y()), view.across(c.x(), c.y()));
  double along = box.along_high - box.along_low, across = box.across_high - box.across_low;
  if (!(along >= 0) || !(across >= 0)) return view;
  const double margin = 0.02 * std::max(along, across) + 1e-9;
  along += 2 * margin;
  across = std::max(across + 2 * margin, 0.15 * along);
  const double middle = 0.5 * (box.across_low + box.across_high);
  view.along_low = box.along_low - margin;
  view.across_high = middle + 0.5 * across;
  view.unit_per_px = std::max(along / max_width, across / max_height);
  view.width = std::max(1, static_cast<std::int32_t>(along / view.unit_per_px));
  view.height = std::max(1, static_cast<std::int32_t>(across / view.unit_per_px));
  return view;
}

ViewSurface resample(const map::GroundGrid& grid, const map::Plane& plane, const PlanView& view) {
  ViewSurface surface;
  surface.relief = host::Raster<float>(view.width, view.height, nothing);
  surface.laid = surface.relief;
  surface.ortho = host::Raster<std::uint8_t>(view.width, view.height);
  const auto radius = static_cast<std::int32_t>(std::min(8.0, 0.5 * view.unit_per_px / grid.cell));
  for (std::int32_t py = 0; py < view.height; ++py) {
    for (std::int32_t px = 0; px < view.width; ++px) {
      const auto [x, y] = view.world(px, py);
      const PixelMean means = mean_around(grid, plane, x, y, radius);
      const bool measured = means.measured.cells > 0;
      const CellMean& mean = measured ? means.measured : means.laid;
      if (mean.cells == 0) continue;
      (measured ? surface.relief : surface.laid).at(px, py) = static_cast<float>(mean.height / mean.cells);
      surface.ortho.at(px, py) = static_cast<std::uint8_t>(mean.grey / mean.cells + 0.5);
    }
  }
  close_small_holes(surface);
  stretch_contrast(surface);
  add_shade(surface, view.unit_per_px);
  return surface;
}

host::Raster<host::Rgba> ortho_picture(const ViewSurface& surface) {
  host::Raster<host::Rgba> picture(surface.ortho.width, surface.ortho.height);
  for (std::int32_t y = 0; y < picture.height; ++y) {
    for (std::int32_t x = 0; x < picture.width; ++x) {
      const std::uint8_t g = surface.ortho.at(x, y);
      if (std::isfinite(surface.relief.at(x, y))) {
        picture.at(x, y) = {g, g, g, 255};
      } else if (std::isfinite(surface.laid.at(x, y))) {
        picture.at(x, y) = hatched(g, x, y);
      }
    }
  }
  return picture;
}

host::Raster<host::Rgba> relief_picture(const ViewSurface& surface, const host::ValueRange& range,
                                        host::ColourMap colours) {
  host::Raster<host::Rgba> picture = host::colour_mapped(surface.relief, range, colours);
  for (std::size_t i = 0; i < picture.samples.size(); ++i) {
    host::Rgba& c = picture.samples[i];
    const double light = 0.35 + 0.95 * surface.shade.samples[i];
    c = {scaled(c.r, light), scaled(c.g, light), scaled(c.b, light), c.a};
  }
  return picture;
}

}  // namespace ilp::report
