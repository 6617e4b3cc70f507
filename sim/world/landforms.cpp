#include "sim/world/landforms.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "sim/world/lattice_noise.hpp"

namespace ilp::world {
namespace {

/// Calls visit(x, y, rng, draw) for the landforms whose centre lies within `reach` of the rectangle, row by row.
template <typename Visit>
void visit_squares(const SizeClass& size, const Rectangle& area, double reach, Visit visit) {
  const auto square = [&](double metres) { return static_cast<std::int32_t>(std::floor(metres / size.cell_m)); };
  const std::int32_t i1 = square(area.x1 + reach);
  const std::int32_t j1 = square(area.y1 + reach);
  for (std::int32_t j = square(area.y0 - reach); j <= j1; ++j) {
    for (std::int32_t i = square(area.x0 - reach); i <= i1; ++i) {
      Rng rng(lattice_hash(i, j, size.seed), size.seed);
      const double draw = rng.uniform();
      if (draw >= size.probability) continue;
      const double x = (i + rng.uniform()) * size.cell_m;
      const double y = (j + rng.uniform()) * size.cell_m;
      visit(x, y, rng, draw);
    }
  }
}

/// A radius of the class, from a uniform number.
double radius_of(const SizeClass& size, double u) {
  return size.radius_m * det_pow(1 + u * (det_pow(2, size.exponent) - 1), -1 / size.exponent);
}

/// Minimum of a and b with its corner rounded over a width k.
double smooth_minimum(double a, double b, double k) {
  const double h = k - std::fabs(a - b);
  return (a < b ? a : b) - (h > 0 ? h * h / (4 * k) : 0);
}

}  // namespace

Dunes::Dunes(const WorldParams& world)
    : height_m_(world.dune_height_m),
      wavelength_m_(world.dune_wavelength_m),
      wind_x_(det_cos(world.dune_direction_rad) / world.dune_wavelength_m),
      wind_y_(det_sin(world.dune_direction_rad) / world.dune_wavelength_m),
      crest_(0.5 + 0.4 * world.dune_asymmetry) {}

Relief Dunes::relief(double x, double y, double warp, double vigour) const {
  const double phase = x * wind_x_ + y * wind_y_ + 0.8 * warp;
  const double place = phase - floor_to_int(phase);
  const double t = place < crest_ ? place / crest_ : (1 - place) / (1 - crest_);
  const double rise = t * t * (3 - 2 * t) - 0.5;
  const double strength = std::clamp(0.75 + 0.6 * vigour, 0.2, 1.0);
  return {height_m_ * strength * rise, 0.25 * strength * rise};
}

Channels::Channels(const WorldParams& world, std::uint32_t seed)
    : width_m_(world.channel_width_m),
      spacing_m_(world.channel_spacing_m),
      swing_m_(world.channel_meander * 0.5 * (world.channel_spacing_m - 2 * world.channel_width_m)),
      bend_m_(5.5 * world.channel_width_m),
      along_x_(det_cos(world.channel_direction_rad)),
      along_y_(det_sin(world.channel_direction_rad)),
      seed_(seed) {
  // A bend wider than it is long would fold the channel.
  swing_m_ = std::min(swing_m_, 0.5 * bend_m_);
}

Channels::Centre Channels::centre(std::int32_t lane, double along_m) const {
  const double s = along_m / bend_m_;
  const std::int32_t i = floor_to_int(s);
  const double t = s - i;
  const auto value = [&](std::int32_t k) { return lattice_hash(k, lane, seed_) * (2.0 / 4294967296.0) - 1; };
  const double a = value(i);
  const double b = value(i + 1);
  const double fade_slope = 30 * t * t * (1 - t) * (1 - t);
  return {(lane + 0.5) * spacing_m_ + swing_m_ * (a + (b - a) * quintic_fade(t)),
          swing_m_ * (b - a) * fade_slope / bend_m_};
}

double Channels::depth(double x, double y) const {
  const double along = along_x_ * x + along_y_ * y;
  const double across = along_x_ * y - along_y_ * x;
  const std::int32_t here = floor_to_int(across / spacing_m_);
  double deepest = 0;
  for (std::int32_t lane = here - 1; lane <= here + 1; ++lane) {
    const double aside = std::fabs(across - (lane + 0.5) * spacing_m_);
    if (aside > swing_m_ + 2 * width_m_) continue;
    const Centre line = centre(lane, along);
    const double distance = std::fabs(across - line.across_m) / std::sqrt(1 + line.slope * line.slope);
    const double t = std::clamp(2 - 4 * distance / width_m_, 0.0, 1.0);
    deepest = std::max(deepest, quintic_fade(t));
  }
  return deepest;
}

double terrace(double height_m, double step_m, double steepness) {
  constexpr double tread_slope = 0.15;  // weathered layers are not level
  const double layers = height_m / step_m;
  const double below = std::floor(layers);
  const double place = layers - below;
  const double width = 1 - 0.9 * steepness;
  const double scarp = std::clamp((place - 0.5) / width + 0.5, 0.0, 1.0);
  return step_m * (below + scarp + tread_slope * steepness * (place - scarp));
}

std::vector<SizeClass> size_classes(double largest_m, double smallest_m, double exponent, double cell_radii,
                                    double density, Rng& rng) {
  std::vector<SizeClass> classes;
  for (double radius = largest_m; radius >= smallest_m; radius *= 0.5) {
    SizeClass size;
    size.radius_m = radius;
    size.cell_m = cell_radii * radius;
    size.seed = rng.next();
    size.exponent = exponent;
    // Each class has four times as many squares as the previous class: equal shares make the exponent 2.
    size.share = det_pow(radius / largest_m, 2 - exponent);
    classes.push_back(size);
  }
  double most = 0;
  for (const SizeClass& size : classes) most = std::max(most, size.share);
  for (SizeClass& size : classes) {
    size.share /= most;
    size.probability = density * size.share;
  }
  return classes;
}

void find_craters(const SizeClass& size, const Rectangle& area, std::vector<Crater>& out) {
  visit_squares(size, area, Crater::reach * size.radius_m, [&](double x, double y, Rng& rng, double) {
    Crater crater;
    crater.x = x;
    crater.y = y;
    crater.radius_m = radius_of(size, rng.uniform());
    const double age = rng.uniform();
    crater.freshness = 0.3 + 0.7 * age * age;
    out.push_back(crater);
  });
}

void find_rocks(const SizeClass& size, const Rectangle& area, std::vector<Rock>& out) {
  visit_squares(size, area, size.radius_m, [&](double x, double y, Rng& rng, double draw) {
    Rock rock;
    rock.x = x;
    rock.y = y;
    const double radius = radius_of(size, rng.uniform());
    const double elongation = 0.6 + 0.4 * rng.uniform();
    const double angle = pi * rng.uniform();
    rock.axis_x_per_m = det_cos(angle) / radius;
    rock.axis_y_per_m = det_sin(angle) / radius;
    rock.cross_x_per_m = -det_sin(angle) / (radius * elongation);
    rock.cross_y_per_m = det_cos(angle) / (radius * elongation);
    rock.reach_m = radius;
    rock.height_m = radius * (0.4 + 0.5 * rng.uniform());
    rock.albedo = 0.7 + 0.7 * rng.uniform();
    rock.draw = draw;
    out.push_back(rock);
  });
}

void find_boulder_fields(const SizeClass& size, const Rectangle& area, std::vector<BoulderField>& out) {
  visit_squares(size, area, size.radius_m, [&](double x, double y, Rng& rng, double) {
    out.push_back({x, y, radius_of(size, rng.uniform())});
  });
}

void find_outcrops(const SizeClass& size, const Rectangle& area, std::vector<Outcrop>& out) {
  visit_squares(size, area, size.radius_m, [&](double x, double y, Rng& rng, double) {
    Outcrop outcrop;
    outcrop.x = x;
    outcrop.y = y;
    outcrop.radius_m = radius_of(size, rng.uniform());
    const double elongation = 0.5 + 0.5 * rng.uniform();
    const double angle = pi * rng.uniform();
    outcrop.axis_x_per_m = det_cos(angle) / outcrop.radius_m;
    outcrop.axis_y_per_m = det_sin(angle) / outcrop.radius_m;
    outcrop.cross_x_per_m = -det_sin(angle) / (outcrop.radius_m * elongation);
    outcrop.cross_y_per_m = det_cos(angle) / (outcrop.radius_m * elongation);
    outcrop.height_m = outcrop.radius_m * (0.12 + 0.15 * rng.uniform());
    outcrop.albedo = rng.uniform() < 0.5 ? 0.8 : 1.2;
    outcrop.seed = rng.next();
    out.push_back(outcrop);
  });
}

Relief crater_relief(const Crater& crater, double x, double y) {
  const double dx = (x - crater.x) / crater.radius_m;
  const double dy = (y - crater.y) / crater.radius_m;
  const double r2 = dx * dx + dy * dy;
  if (r2 >= Crater::reach * Crater::reach) return {};
  const double r = std::sqrt(r2);
  const double depth = 0.4 * crater.radius_m * crater.freshness;
  const double rim = 0.08 * crater.radius_m * crater.freshness;
  const double fall = (Crater::reach - r) / (Crater::reach - 1);
  const double ejecta = rim * fall * fall * fall;
  const double bowl = (depth + rim) * r2 - depth;
  Relief relief;
  relief.height_m = smooth_minimum(bowl, ejecta, 0.25 * depth);
  const double bright = r < 1 ? 0.35 * r2 : 0.35 * fall * fall;
  relief.albedo = 1 + bright * crater.freshness;
  return relief;
}

Relief rock_relief(const Rock& rock, double x, double y) {
  const double dx = x - rock.x;
  const double dy = y - rock.y;
  const double a = dx * rock.axis_x_per_m + dy * rock.axis_y_per_m;
  const double b = dx * rock.cross_x_per_m + dy * rock.cross_y_per_m;
  const double r2 = a * a + b * b;
  if (r2 >= 1) return {};
  return {rock.height_m * std::sqrt(1 - r2), rock.albedo};
}

Relief outcrop_relief(const Outcrop& outcrop, double x, double y) {
  constexpr double ledges = 3;
  constexpr double block_radii = 1.0 / 7;
  const double dx = x - outcrop.x;
  const double dy = y - outcrop.y;
  const double a = dx * outcrop.axis_x_per_m + dy * outcrop.axis_y_per_m;
  const double b = dx * outcrop.cross_x_per_m + dy * outcrop.cross_y_per_m;
  // A ragged edge: the ellipse is up to a fifth smaller.
  const double ragged = 1 + 0.1 * (1 + value_noise(3 * a, 3 * b, outcrop.seed));
  const double r2 = (a * a + b * b) * ragged * ragged;
  if (r2 >= 1) return {};
  const double level = ledges * (1 - r2);
  const double below = std::floor(level);
  const double ledge = (below + std::min(1.0, 4 * (level - below))) / ledges;
  const auto block = [&](double along) { return floor_to_int(along / block_radii); };
  const double block_height = lattice_hash(block(a), block(b), outcrop.seed) * (0.3 / 4294967296.0);
  return {outcrop.height_m * ledge * (1 + block_height - 0.15), outcrop.albedo * (0.9 + 0.67 * block_height)};
}

}  // namespace ilp::world
