#include "sim/ground/report/oblique_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/host/statistics.hpp"

namespace ilp::report {
namespace {

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
  std::vector<std::size_t> piece;
  for (std::size_t start = 0; start < relief.samples.size(); ++start) {
    if (visited[start] || !std::isfinite(relief.samples[start])) continue;
    piece.assign(1, start);
    visited[start] = true;
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const auto x = static_cast<std::int32_t>(piece[next] % static_cast<std::size_t>(relief.width));
      const auto y = static_cast<std::int32_t>(piece[next] / static_cast<std::size_t>(relief.width));
      for (const auto& [i, j] : {std::pair(x - 1, y), std::pair(x + 1, y), std::pair(x, y - 1), std::pair(x, y + 1)}) {
        if (!relief.contains(i, j)) continue;
        const std::size_t neighbour = relief.index(i, j);
        if (visited[neighbour] || !std::isfinite(relief.samples[neighbour])) continue;
        visited[neighbour] = true;
        piece.push_back(neighbour);
      }
    }
    if (piece.size() >= speck) continue;
    for (const std::size_t i : piece) relief.samples[i] = std::numeric_limits<float>::quiet_NaN();
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

}  // namespace

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
