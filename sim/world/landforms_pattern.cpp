#include "sim/world/landforms_pattern.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "sim/world/lattice_noise.hpp"

namespace ilp::world {

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

}  // namespace ilp::world
