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

// In units of plan-view pixels: x along the track, y across it (to the left), z up from the mean plane.
struct ScenePoint {
  double x = 0, y = 0, z = 0;
};

struct ScreenPoint {
  double x = 0, y = 0, distance = 0;
};

constexpr double elevation_rad = 0.62, azimuth_rad = 0.35;
constexpr std::int32_t supersampling = 2;

class Projector {
 public:
  Projector(const PlanView& view) : half_width_(0.5 * view.width), half_height_(0.5 * view.height) {
    distance_ = 2.2 * std::hypot(view.width, view.height);
  }

  void fit(const std::vector<ScenePoint>& points, std::int32_t width, std::int32_t max_height) {
    double left = std::numeric_limits<double>::max(), right = -left, top = left, bottom = -left;
    for (const ScenePoint& p : points) {
      const ScreenPoint s = (*this)(p);
      left = std::min(left, s.x);
      right = std::max(right, s.x);
      top = std::min(top, s.y);
      bottom = std::max(bottom, s.y);
    }
    const double margin = 0.04 * std::max(right - left, bottom - top) + 1;
    const double scale = std::min(width / (right - left + 2 * margin), max_height / (bottom - top + 2 * margin));
    shift_x_ = -scale * (left - margin);
    shift_y_ = -scale * (top - margin);
    scale_ = scale;
    width_ = std::max(1, static_cast<std::int32_t>(scale * (right - left + 2 * margin)));
    height_ = std::max(1, static_cast<std::int32_t>(scale * (bottom - top + 2 * margin)));
  }

  ScreenPoint operator()(const ScenePoint& p) const {
    const double x = p.x - half_width_, y = p.y + half_height_;
    const double right = std::cos(azimuth_rad) * x - std::sin(azimuth_rad) * y;
    const double ahead = std::sin(azimuth_rad) * x + std::cos(azimuth_rad) * y;
    const double up = std::sin(elevation_rad) * ahead + std::cos(elevation_rad) * p.z;
    const double far = distance_ + std::cos(elevation_rad) * ahead - std::sin(elevation_rad) * p.z;
    const double perspective = distance_ / std::max(far, 0.05 * distance_);
    return {shift_x_ + scale_ * right * perspective, shift_y_ - scale_ * up * perspective, far};
  }

  [[nodiscard]] std::int32_t width() const { return width_; }
  [[nodiscard]] std::int32_t height() const { return height_; }

 private:
  double half_width_, half_height_, distance_ = 1;
  double scale_ = 1, shift_x_ = 0, shift_y_ = 0;
  std::int32_t width_ = 0, height_ = 0;
};

class Canvas {
 public:
  Canvas(std::int32_t width, std::int32_t height)
      : colour_(width, height), distance_(width, height, std::numeric_limits<float>::max()) {}

  void triangle(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c, const host::Rgba& colour) {
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(std::fabs(area) > 1e-9)) return;
    const auto clip = [](double v, std::int32_t size) {
      return static_cast<std::int32_t>(std::clamp(v, 0.0, size - 1.0));
    };
    const std::int32_t x1 = clip(std::ceil(std::max({a.x, b.x, c.x})), colour_.width);
    const std::int32_t y1 = clip(std::ceil(std::max({a.y, b.y, c.y})), colour_.height);
    for (std::int32_t y = clip(std::floor(std::min({a.y, b.y, c.y})), colour_.height); y <= y1; ++y) {
      for (std::int32_t x = clip(std::floor(std::min({a.x, b.x, c.x})), colour_.width); x <= x1; ++x) {
        const double u = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
        const double v = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        const auto far = static_cast<float>(a.distance + u * (b.distance - a.distance) + v * (c.distance - a.distance));
        if (far >= distance_.at(x, y)) continue;
        distance_.at(x, y) = far;
        colour_.at(x, y) = colour;
      }
    }
  }

  // Mean of each block; what lies outside the terrain stays transparent in proportion.
  [[nodiscard]] host::Raster<host::Rgba> reduced() const {
    host::Raster<host::Rgba> small(colour_.width / supersampling, colour_.height / supersampling);
    for (std::int32_t y = 0; y < small.height; ++y) {
      for (std::int32_t x = 0; x < small.width; ++x) {
        int r = 0, g = 0, b = 0, covered = 0;
        for (std::int32_t k = 0; k < supersampling * supersampling; ++k) {
          const host::Rgba& c =
              colour_.at(x * supersampling + k % supersampling, y * supersampling + k / supersampling);
          if (c.a == 0) continue;
          r += c.r;
          g += c.g;
          b += c.b;
          ++covered;
        }
        if (covered == 0) continue;
        const auto mean = [covered](int sum) { return static_cast<std::uint8_t>(sum / covered); };
        small.at(x, y) = {mean(r), mean(g), mean(b),
                          static_cast<std::uint8_t>(255 * covered / (supersampling * supersampling))};
      }
    }
    return small;
  }

 private:
  host::Raster<host::Rgba> colour_;
  host::Raster<float> distance_;
};

// What would spoil the picture: heights far outside the others, and specks that hang in the void.
host::Raster<float> tidied_relief(const ViewSurface& surface) {
  host::Raster<float> relief = surface.relief;
  std::vector<double> heights;
  for (const float z : relief.samples) {
    if (std::isfinite(z)) heights.push_back(z);
  }
  if (heights.empty()) return relief;
  const double low = host::percentile(heights, 0.005), high = host::percentile(heights, 0.995),
               slack = 0.5 * (high - low);
  for (float& z : relief.samples) {
    if (z < low - slack || z > high + slack) z = std::numeric_limits<float>::quiet_NaN();
  }
  const std::size_t speck = heights.size() / 200;
  std::vector<bool> visited(relief.samples.size());
  std::vector<std::size_t> patch;
  for (std::size_t start = 0; start < relief.samples.size(); ++start) {
    if (visited[start] || !std::isfinite(relief.samples[start])) continue;
    patch.assign(1, start);
    visited[start] = true;
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const auto x = static_cast<std::int32_t>(patch[next] % static_cast<std::size_t>(relief.width));
      const auto y = static_cast<std::int32_t>(patch[next] / static_cast<std::size_t>(relief.width));
      for (const auto& [i, j] : {std::pair(x - 1, y), std::pair(x + 1, y), std::pair(x, y - 1), std::pair(x, y + 1)}) {
        if (!relief.contains(i, j)) continue;
        const std::size_t neighbour = relief.index(i, j);
        if (visited[neighbour] || !std::isfinite(relief.samples[neighbour])) continue;
        visited[neighbour] = true;
        patch.push_back(neighbour);
      }
    }
    if (patch.size() >= speck) continue;
    for (const std::size_t i : patch) relief.samples[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return relief;
}

// A cell of the picture with ground at all corners, and no cliff so steep that it must be two surfaces.
bool is_ground(const host::Raster<float>& relief, std::int32_t x, std::int32_t y, double unit_per_px) {
  constexpr double steepest = 8;
  const float corners[] = {relief.at(x, y), relief.at(x + 1, y), relief.at(x, y + 1), relief.at(x + 1, y + 1)};
  float low = corners[0], high = corners[0];
  for (const float z : corners) {
    if (!std::isfinite(z)) return false;
    low = std::min(low, z);
    high = std::max(high, z);
  }
  return high - low < steepest * unit_per_px;
}

// Relief is shown at about a tenth of the picture's smaller side, but never reduced.
double relief_exaggeration(const host::Raster<float>& relief, const PlanView& view) {
  const host::ValueRange range = host::display_range(relief);
  const double shown_px = (range.high - range.low) / view.unit_per_px;
  return shown_px > 0 ? std::clamp(0.1 * std::min(view.width, view.height) / shown_px, 1.0, 4.0) : 1.0;
}

host::Rgba lit(const ViewSurface& surface, std::int32_t x, std::int32_t y) {
  const double value = surface.ortho.at(x, y) * (0.55 + 0.65 * surface.shade.at(x, y));
  const auto grey = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
  return {grey, grey, grey, 255};
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

ObliqueView draw_oblique(const ViewSurface& surface, const PlanView& view, const map::Plane& plane,
                         const std::vector<Vec3>& track, std::int32_t width) {
  ObliqueView oblique;
  const host::Raster<float> relief = tidied_relief(surface);
  oblique.exaggeration = relief_exaggeration(relief, view);
  const double lift = oblique.exaggeration / view.unit_per_px;
  const auto scene = [&](std::int32_t x, std::int32_t y) {
    return ScenePoint{static_cast<double>(x), -static_cast<double>(y), lift * relief.at(x, y)};
  };
  std::vector<ScenePoint> cameras, feet, all;
  for (const Vec3& c : track) {
    const double x = view.px(c.x(), c.y()), y = -view.py(c.x(), c.y());
    cameras.push_back({x, y, (c.z() - plane.at(c.x(), c.y())) / view.unit_per_px});
    feet.push_back({x, y, 0});
  }
  for (std::int32_t y = 0; y < view.height; y += 4) {
    for (std::int32_t x = 0; x < view.width; x += 4) {
      if (std::isfinite(relief.at(x, y))) all.push_back(scene(x, y));
    }
  }
  if (all.empty()) return oblique;
  all.insert(all.end(), cameras.begin(), cameras.end());

  Projector projector(view);
  projector.fit(all, width * supersampling, width * supersampling * 3 / 4);
  Canvas canvas(projector.width(), projector.height());
  for (std::int32_t y = 0; y + 1 < view.height; ++y) {
    for (std::int32_t x = 0; x + 1 < view.width; ++x) {
      if (!is_ground(relief, x, y, view.unit_per_px)) continue;
      const ScreenPoint a = projector(scene(x, y)), b = projector(scene(x + 1, y));
      const ScreenPoint c = projector(scene(x, y + 1)), d = projector(scene(x + 1, y + 1));
      const host::Rgba colour = lit(surface, x, y);
      canvas.triangle(a, b, c, colour);
      canvas.triangle(b, d, c, colour);
    }
  }
  oblique.picture = canvas.reduced();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const ScreenPoint camera = projector(cameras[i]), foot = projector(feet[i]);
    oblique.track.push_back({camera.x / supersampling, camera.y / supersampling});
    oblique.below.push_back({foot.x / supersampling, foot.y / supersampling});
  }
  return oblique;
}

}  // namespace ilp::report
