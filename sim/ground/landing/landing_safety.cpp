#include "sim/ground/landing/landing_safety.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/host/statistics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::landing {
namespace {

constexpr double usual_slope_deg = 10, usual_step_share = 0.1;
/// One-sigma errors of a height that a step must reach to be told from noise.
constexpr double least_step_sigmas = 3;
/// A rock of so many cells may be missed, because a window of matching is wider: a site has room for one beside its
/// measured step.
constexpr double unseen_rock_cells = 4;
/// A footprint as even as the smoothest maps are, and a rock that was missed.
constexpr double least_step_cells = unseen_rock_cells + 2;

/// The upper tail of the normal distribution.
double tail(double x) {
  return 0.5 * std::erfc(x / std::numbers::sqrt2);
}

double number_from(const std::string& word, const char* what, double least, double most, const char* unit) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !(value >= least && value <= most)) {
    throw std::runtime_error("landing sites: " + std::string(what) + " '" + word + "' is not a number from " +
                             host::brief(least) + " to " + host::brief(most) + " " + unit);
  }
  return value;
}

std::vector<LandingSite> best_sites(const LandingMap& map, const host::Raster<float>& unsafe,
                                    const map::GroundGrid& grid) {
  const FootprintHazards& hazards = map.hazards;
  const double unseen = unseen_rock_cells * map.metres_per_unit * grid.cell;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < unsafe.samples.size(); ++i) {
    const bool capacity = hazards.step_m.samples[i] + unseen <= map.limits.step_m;
    if (capacity && unsafe.samples[i] <= 1 - least_safe) order.push_back(i);
  }
  // Where the risk is the same to the last digit, the lower step is better.
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (unsafe.samples[a] != unsafe.samples[b]) return unsafe.samples[a] < unsafe.samples[b];
    return hazards.step_m.samples[a] < hazards.step_m.samples[b];
  });
  const double apart = map.limits.footprint_m / (map.metres_per_unit * hazards.geometry.cell);
  std::vector<LandingSite> sites;
  for (const std::size_t i : order) {
    if (sites.size() == most_sites) break;
    LandingSite site;
    site.column = static_cast<std::int32_t>(i % static_cast<std::size_t>(hazards.geometry.columns));
    site.row = static_cast<std::int32_t>(i / static_cast<std::size_t>(hazards.geometry.columns));
    const bool near = std::any_of(sites.begin(), sites.end(), [&](const LandingSite& other) {
      const double dx = other.column - site.column, dy = other.row - site.row;
      return dx * dx + dy * dy < apart * apart;
    });
    if (near) continue;
    site.x = hazards.geometry.x0 + site.column * hazards.geometry.cell;
    site.y = hazards.geometry.y0 - site.row * hazards.geometry.cell;
    site.z = grid.height.at(site.column * hazards.stride, site.row * hazards.stride);
    site.slope_rad = map.slope_rad.samples[i];
    site.roughness_m = hazards.roughness_m.samples[i];
    site.step_m = hazards.step_m.samples[i];
    site.safe = map.safe.samples[i];
    sites.push_back(site);
  }
  return sites;
}

/// The step must stand out of the noise, and what is as high must be wide enough for matching to see it.
void check_step(const FootprintHazards& hazards, const LandingLimits& limits, double cell_m) {
  std::vector<double> sigmas;
  for (const float sigma : hazards.sigma_m.samples) {
    if (std::isfinite(sigma)) sigmas.push_back(sigma);
  }
  if (sigmas.empty()) {
    throw std::runtime_error("no footprint of " + host::brief(limits.footprint_m) +
                             " m is covered by heights: name a smaller one");
  }
  const double least = std::max(least_step_sigmas * host::median(std::move(sigmas)), least_step_cells * cell_m);
  // The message has three digits of it.
  if (limits.step_m < 0.99 * least) {
    throw std::runtime_error("a step of " + host::brief(limits.step_m) + " m is too low for this map to show: name " +
                             host::brief(least) + " m or more");
  }
}

}  // namespace

LandingLimits read_landing_limits(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (c == ',') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  if (words.size() != 1 && words.size() != 3) {
    throw std::runtime_error("landing sites: expected FOOTPRINT_M or FOOTPRINT_M,SLOPE_DEG,STEP_M, not '" + text + "'");
  }
  LandingLimits limits;
  limits.footprint_m = number_from(words[0], "the footprint", 0.01, 10000, "m");
  limits.slope_rad = usual_slope_deg * degree;
  limits.step_m = usual_step_share * limits.footprint_m;
  if (words.size() == 1) return limits;
  limits.slope_rad = number_from(words[1], "the slope", 0.1, 60, "degrees") * degree;
  limits.step_m = number_from(words[2], "the step", 0.001, 1000, "m");
  return limits;
}

double steep_probability(double gradient, double sigma, double limit) {
  constexpr double certain = 10;
  if (!(std::fabs(limit - gradient) < certain * sigma)) return gradient > limit ? 1 : 0;
  // Along the mean gradient x, across it y; x beyond the circle, or y beyond it at this x (midpoints of the chord).
  double steep = tail((limit - gradient) / sigma) + tail((limit + gradient) / sigma);
  constexpr int nodes = 96;
  const double low = std::max(-limit, gradient - 8 * sigma), high = std::min(limit, gradient + 8 * sigma);
  if (!(high > low)) return std::min(steep, 1.0);
  const double step = (high - low) / nodes;
  for (int k = 0; k < nodes; ++k) {
    const double x = low + (k + 0.5) * step, u = (x - gradient) / sigma;
    const double density = std::exp(-0.5 * u * u) / (sigma * std::sqrt(2 * std::numbers::pi));
    steep += step * density * 2 * tail(std::sqrt(limit * limit - x * x) / sigma);
  }
  return std::min(steep, 1.0);
}

double uneven_probability(double step_m, double sigma_m, double limit_m, double cells_across) {
  const double noise = noise_range * sigma_m;
  // Noise is never taken for more than half of a step, and a step is never told finer than a height.
  const double step =
      (1 + lowered_cells / cells_across) *
      std::sqrt(std::max({step_m * step_m - noise * noise, 0.25 * step_m * step_m, sigma_m * sigma_m, 1e-18}));
  const double own = step_noise * sigma_m / step;
  return tail(std::log(limit_m / step) / std::sqrt(step_log_variance / cells_across + own * own));
}

LandingMap assess_landing(const map::GroundGrid& grid, double metres_per_unit, double tilt_sigma_rad,
                          const LandingLimits& limits) {
  LandingMap map;
  map.limits = limits;
  map.metres_per_unit = metres_per_unit;
  map.tilt_sigma_rad = tilt_sigma_rad;
  map.hazards = footprint_hazards(grid, {limits.footprint_m, metres_per_unit});
  const FootprintHazards& hazards = map.hazards;
  check_step(hazards, limits, metres_per_unit * grid.cell);
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  map.slope_rad = host::Raster<float>(hazards.geometry.columns, hazards.geometry.rows, nothing);
  map.safe = map.slope_rad;
  host::Raster<float> unsafe = map.slope_rad;
  const double steepest = std::tan(limits.slope_rad), across = limits.footprint_m / (metres_per_unit * grid.cell);
  for (std::size_t i = 0; i < unsafe.samples.size(); ++i) {
    if (!std::isfinite(hazards.step_m.samples[i])) continue;
    const double gx = hazards.gradient_x.samples[i], gy = hazards.gradient_y.samples[i];
    const double own = hazards.gradient_sigma.samples[i], gradient = std::sqrt(gx * gx + gy * gy);
    const double steep = steep_probability(gradient, std::sqrt(own * own + tilt_sigma_rad * tilt_sigma_rad), steepest);
    const double uneven =
        uneven_probability(hazards.step_m.samples[i], hazards.sigma_m.samples[i], limits.step_m, across);
    const double risk = steep + uneven - steep * uneven;
    map.slope_rad.samples[i] = static_cast<float>(std::atan(gradient));
    unsafe.samples[i] = static_cast<float>(risk);
    map.safe.samples[i] = static_cast<float>(1 - risk);
  }
  map.sites = best_sites(map, unsafe, grid);
  return map;
}

}  // namespace ilp::landing
