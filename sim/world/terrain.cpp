#include "sim/world/terrain.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "sim/world/sun.hpp"

namespace ilp::sim {
namespace {

void check(bool right, const char* field, const char* expected) {
  if (!right) throw std::invalid_argument(std::string("world: ") + field + " must be " + expected);
}

void validate(const WorldParams& p) {
  check(p.relief_m > 0 && p.relief_m < 1e5, "relief_m", "positive");
  check(p.post_spacing_m > 0 && p.post_spacing_m < 1e4, "post_spacing_m", "positive");
  check(p.shortest_wavelength_m >= 2 * p.post_spacing_m, "shortest_wavelength_m", "at least two post spacings");
  check(p.longest_wavelength_m >= p.shortest_wavelength_m && p.longest_wavelength_m < 1e6, "longest_wavelength_m",
        "at least shortest_wavelength_m");
  check(p.hurst >= 0 && p.hurst <= 2, "hurst", "in 0 to 2");
  check(p.smallest_crater_radius_m >= p.post_spacing_m && p.largest_crater_radius_m < 1e5, "crater radii",
        "at least one post spacing");
  check(p.smallest_rock_radius_m >= p.post_spacing_m && p.largest_rock_radius_m < 1e5, "rock radii",
        "at least one post spacing");
  check(p.crater_density >= 0 && p.crater_density <= 1, "crater_density", "in 0 to 1");
  check(p.rock_density >= 0 && p.rock_density <= 1, "rock_density", "in 0 to 1");
  check(p.sun_azimuth_rad > -100 && p.sun_azimuth_rad < 100, "sun_azimuth_rad", "an angle in radians");
  check(p.sun_elevation_rad > 0.05 && p.sun_elevation_rad < 1.58, "sun_elevation_rad", "in 0.05 to pi/2");
  check(p.ambient >= 0 && p.ambient <= 1, "ambient", "in 0 to 1");
  check(p.albedo_contrast >= 0 && p.albedo_contrast <= 1, "albedo_contrast", "in 0 to 1");
}

Octave octave(double wavelength_m, double amplitude, Rng& rng) {
  Octave result;
  result.wavelength_m = wavelength_m;
  result.amplitude = amplitude;
  result.offset_x = rng.uniform();
  result.offset_y = rng.uniform();
  result.seed = rng.next();
  return result;
}

std::vector<SizeClass> size_classes(double largest_m, double smallest_m, double cell_radii, double probability,
                                    Rng& rng) {
  std::vector<SizeClass> classes;
  for (double radius = largest_m; radius >= smallest_m; radius *= 0.5) {
    classes.push_back({radius, cell_radii * radius, probability, rng.next()});
  }
  return classes;
}

Rectangle extent(double first_i, double first_j, double columns, double rows, double spacing) {
  return {first_i * spacing, first_j * spacing, (first_i + columns - 1) * spacing, (first_j + rows - 1) * spacing};
}

/// Calls visit(i, j, x, y) for the posts, counted from the first, within `reach` of (x, y).
template <typename Visit>
void visit_posts(std::int32_t first_i, std::int32_t first_j, std::int32_t columns, std::int32_t rows, double spacing,
                 double x, double y, double reach, Visit visit) {
  const auto post = [&](double metres) { return static_cast<std::int32_t>(std::floor(metres / spacing)); };
  const std::int32_t i0 = std::max(0, post(x - reach) - first_i);
  const std::int32_t i1 = std::min(columns - 1, post(x + reach) + 1 - first_i);
  const std::int32_t j0 = std::max(0, post(y - reach) - first_j);
  const std::int32_t j1 = std::min(rows - 1, post(y + reach) + 1 - first_j);
  for (std::int32_t j = j0; j <= j1; ++j) {
    for (std::int32_t i = i0; i <= i1; ++i) visit(i, j, (first_i + i) * spacing, (first_j + j) * spacing);
  }
}

}  // namespace

Terrain::Terrain(const WorldParams& params) : params_(params) {
  validate(params);
  Rng rng(params.seed, 1);
  const double longest = params.longest_wavelength_m;
  for (double wavelength = longest; wavelength >= params.shortest_wavelength_m; wavelength *= 0.5) {
    const double amplitude = 0.5 * params.relief_m * det_pow(wavelength / longest, params.hurst);
    height_octaves_.push_back(octave(wavelength, amplitude, rng));
  }
  // Brightness varies most at the finest scales: the eye of the matcher looks there, and relief rules the others.
  const double coarsest_albedo = 0.4 * longest;
  for (double wavelength = coarsest_albedo; wavelength >= 4 * params.post_spacing_m; wavelength *= 0.5) {
    const double share = 0.3 * (1 - 0.7 * wavelength / coarsest_albedo);
    albedo_octaves_.push_back(octave(wavelength, share * params.albedo_contrast, rng));
  }
  for (int k = 0; k < 6; ++k) {
    const double wavelength = 3.2 * params.post_spacing_m * std::ldexp(1.0, -k);
    detail_octaves_.push_back(octave(wavelength, 0.5 * params.albedo_contrast, rng));
  }
  rockiness_ = octave(0.25 * longest, 1, rng);
  craters_ =
      size_classes(params.largest_crater_radius_m, params.smallest_crater_radius_m, 3.2, params.crater_density, rng);
  rocks_ = size_classes(params.largest_rock_radius_m, params.smallest_rock_radius_m, 6, params.rock_density, rng);
}

void Terrain::add_fractal(Posts& posts) const {
  const PostGrid grid{posts.first_i, posts.first_j, posts.columns, posts.rows, params_.post_spacing_m};
  for (const Octave& o : height_octaves_) add_octave(o, grid, posts.height);
  for (const Octave& o : albedo_octaves_) add_octave(o, grid, posts.albedo);
}

void Terrain::add_craters(Posts& posts) const {
  const double spacing = params_.post_spacing_m;
  const Rectangle area = extent(posts.first_i, posts.first_j, posts.columns, posts.rows, spacing);
  std::vector<Crater> craters;
  for (const SizeClass& size : craters_) find_craters(size, area, craters);
  for (const Crater& crater : craters) {
    visit_posts(posts.first_i, posts.first_j, posts.columns, posts.rows, spacing, crater.x, crater.y,
                Crater::reach * crater.radius_m, [&](std::int32_t i, std::int32_t j, double x, double y) {
                  const Relief relief = crater_relief(crater, x, y);
                  const auto at = static_cast<std::size_t>(j) * static_cast<std::size_t>(posts.columns) +
                                  static_cast<std::size_t>(i);
                  posts.height[at] += relief.height_m;
                  posts.albedo[at] *= relief.albedo;
                });
  }
}

void Terrain::add_rocks(Posts& posts) const {
  const double spacing = params_.post_spacing_m;
  const Rectangle area = extent(posts.first_i, posts.first_j, posts.columns, posts.rows, spacing);
  std::vector<Rock> rocks;
  for (const SizeClass& size : rocks_) find_rocks(size, area, rocks);
  for (const Rock& rock : rocks) {
    const double noise =
        value_noise(rock.x / rockiness_.wavelength_m, rock.y / rockiness_.wavelength_m, rockiness_.seed);
    if (noise < -0.2) continue;
    visit_posts(posts.first_i, posts.first_j, posts.columns, posts.rows, spacing, rock.x, rock.y, rock.reach_m,
                [&](std::int32_t i, std::int32_t j, double x, double y) {
                  const Relief relief = rock_relief(rock, x, y);
                  const auto at = static_cast<std::size_t>(j) * static_cast<std::size_t>(posts.columns) +
                                  static_cast<std::size_t>(i);
                  posts.height[at] += relief.height_m;
                  posts.albedo[at] *= relief.albedo;
                });
  }
}

Terrain::Posts Terrain::posts(std::int32_t first_i, std::int32_t first_j, std::int32_t columns,
                              std::int32_t rows) const {
  Posts result{first_i, first_j, columns, rows, {}, {}};
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  result.height.assign(count, 0.0);
  result.albedo.assign(count, 0.0);
  add_fractal(result);
  // Brightness is a product of factors: it cannot become negative, and bright and dark are balanced.
  for (double& albedo : result.albedo) albedo = det_exp(albedo);
  add_craters(result);
  add_rocks(result);
  for (double& height : result.height) height = std::clamp(height, lowest(), highest());
  return result;
}

double Terrain::height(double x, double y) const {
  const double spacing = params_.post_spacing_m;
  const double floor_u = std::floor(x / spacing);
  const double floor_v = std::floor(y / spacing);
  const Posts p = posts(static_cast<std::int32_t>(floor_u), static_cast<std::int32_t>(floor_v), 2, 2);
  const double u = x / spacing - floor_u;
  const double v = y / spacing - floor_v;
  const auto h = [&](std::size_t k) { return static_cast<double>(static_cast<float>(p.height[k])); };
  const double near = h(0) + (h(1) - h(0)) * u;
  const double far = h(2) + (h(3) - h(2)) * u;
  return near + (far - near) * v;
}

Vec3 Terrain::normal(double x, double y) const {
  const double spacing = params_.post_spacing_m;
  const double slope_x = (height(x + spacing, y) - height(x - spacing, y)) / (2 * spacing);
  const double slope_y = (height(x, y + spacing) - height(x, y - spacing)) / (2 * spacing);
  return Vec3(-slope_x, -slope_y, 1) / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
}

SurfacePatch Terrain::patch(const Rectangle& area) const {
  const double spacing = params_.post_spacing_m;
  SurfacePatch result;
  result.spacing_m = spacing;
  result.first_i = static_cast<std::int32_t>(std::floor(area.x0 / spacing));
  result.first_j = static_cast<std::int32_t>(std::floor(area.y0 / spacing));
  result.columns = static_cast<std::int32_t>(std::floor(area.x1 / spacing)) + 2 - result.first_i;
  result.rows = static_cast<std::int32_t>(std::floor(area.y1 / spacing)) + 2 - result.first_j;
  const Sunlight sun(params_.sun_azimuth_rad, params_.sun_elevation_rad, spacing, highest() - lowest());
  const PostMargin& margin = sun.margin();
  const Posts wide = posts(result.first_i - margin.left, result.first_j - margin.below,
                           result.columns + margin.left + margin.right, result.rows + margin.below + margin.above);
  std::vector<double> direct;
  sun.direct(wide.height, wide.columns, wide.rows, direct);
  result.height_m.reserve(direct.size());
  result.radiance.reserve(direct.size());
  for (std::int32_t j = 0; j < result.rows; ++j) {
    const std::size_t begin = static_cast<std::size_t>(j + margin.below) * static_cast<std::size_t>(wide.columns) +
                              static_cast<std::size_t>(margin.left);
    for (std::int32_t i = 0; i < result.columns; ++i) {
      const double light = params_.ambient + (1 - params_.ambient) * direct[result.index(i, j)];
      result.height_m.push_back(static_cast<float>(wide.height[begin + static_cast<std::size_t>(i)]));
      result.radiance.push_back(static_cast<float>(wide.albedo[begin + static_cast<std::size_t>(i)] * light));
    }
  }
  return result;
}

}  // namespace ilp::sim
