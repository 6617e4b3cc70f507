#include "sim/tools/richness/planted_world.hpp"

#include <array>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::richness {
namespace {

struct Range {
  double low, high;
};

/// Draws from ranges; those of the held-out set are wider by a fifth of their length at either end where they may be.
class Draw {
 public:
  Draw(WorldSet set, std::uint64_t seed) : rng_(seed, set == WorldSet::tuning ? 31 : 32), set_(set) {}

  double within(Range tuning, Range held_out) {
    const Range range = set_ == WorldSet::tuning ? tuning : held_out;
    return range.low + (range.high - range.low) * rng_.uniform();
  }
  double within(Range both) { return within(both, both); }
  std::uint64_t seed() { return rng_.next(); }

 private:
  Rng rng_;
  WorldSet set_;
};

void lay_ground(GroundKind ground, Draw& draw, world::WorldParams& w) {
  w.post_spacing_m = 0.25;
  w.longest_wavelength_m = draw.within({120, 200}, {100, 250});
  w.shortest_wavelength_m = 1;
  w.relief_m = draw.within({1, 4}, {0.6, 5});
  w.hurst = draw.within({0.85, 1}, {0.8, 1.05});
  w.albedo_contrast = draw.within({0.3, 0.7}, {0.2, 0.8});
  w.sun_elevation_rad = draw.within({0.5, 1.1}, {0.4, 1.25});
  w.sun_azimuth_rad = draw.within({0, 6.28});
  w.ambient = draw.within({0.2, 0.4}, {0.15, 0.5});
  // Small craters and stones lie on all of it: they are no features.
  w.largest_crater_radius_m = 1.5;
  w.smallest_crater_radius_m = 0.75;
  w.crater_density = draw.within({0, 0.15}, {0, 0.25});
  w.largest_rock_radius_m = 0.7;
  w.smallest_rock_radius_m = 0.3;
  w.rock_density = draw.within({0, 0.2}, {0, 0.3});
  switch (ground) {
    case GroundKind::dunes:
      w.dune_height_m = draw.within({0.2, 0.5}, {0.15, 0.6});
      w.dune_wavelength_m = draw.within({8, 14}, {6, 18});
      w.dune_direction_rad = draw.within({0, 6.28});
      break;
    case GroundKind::hills:
      w.longest_wavelength_m = draw.within({280, 400}, {250, 450});
      w.relief_m = draw.within({18, 32}, {15, 40});
      w.hurst = draw.within({1.15, 1.3}, {1.1, 1.4});
      break;
    case GroundKind::hazy:
      w.ambient = draw.within({0.5, 0.7}, {0.45, 0.8});
      break;
    case GroundKind::stark:
      w.albedo_contrast = draw.within({0.85, 1}, {0.8, 1});
      w.sun_elevation_rad = draw.within({0.25, 0.4}, {0.2, 0.4});
      break;
    default:
      break;
  }
}

void plant(world::FeatureKind feature, Draw& draw, world::WorldParams& w) {
  switch (feature) {
    case world::FeatureKind::crater:
      w.largest_crater_radius_m = draw.within({8, 14}, {6, 17});
      w.smallest_crater_radius_m = 0.5 * w.largest_crater_radius_m;
      w.crater_density = draw.within({0.12, 0.2}, {0.1, 0.22});
      break;
    case world::FeatureKind::outcrop:
      w.outcrop_radius_m = draw.within({8, 14}, {6, 18});
      w.outcrop_density = draw.within({0.2, 0.35}, {0.15, 0.4});
      break;
    case world::FeatureKind::scarp:
      w.relief_m = w.relief_m + draw.within({7, 11}, {6, 13});
      w.hurst = w.hurst + 0.2;
      w.terrace_step_m = w.relief_m * draw.within({0.5, 0.65}, {0.45, 0.7});
      w.terrace_steepness = draw.within({0.8, 0.9}, {0.75, 0.95});
      break;
    case world::FeatureKind::channel:
      w.channel_depth_m = draw.within({1.2, 2.5}, {1, 3});
      w.channel_width_m = draw.within({7, 12}, {6, 15});
      w.channel_spacing_m = draw.within({110, 150}, {90, 170});
      w.channel_direction_rad = draw.within({0.9, 2.2}, {0.7, 2.4});
      break;
    case world::FeatureKind::boulder_field:
      w.largest_rock_radius_m = draw.within({1.6, 2.3}, {1.55, 2.6});
      w.smallest_rock_radius_m = 0.4;
      w.rock_density *= 0.1;
      w.boulder_field_layers = 6;
      w.boulder_field_radius_m = draw.within({10, 18}, {8, 20});
      w.boulder_field_density = draw.within({0.3, 0.45}, {0.25, 0.5});
      w.boulder_field_rock_density = draw.within({0.8, 1}, {0.7, 1});
      break;
    case world::FeatureKind::rock:
      break;
  }
}

/// All lengths of a world that was made for an altitude of 100 m.
void scale_lengths(double factor, world::WorldParams& w) {
  for (double* length :
       {&w.relief_m, &w.longest_wavelength_m, &w.shortest_wavelength_m, &w.post_spacing_m, &w.largest_crater_radius_m,
        &w.smallest_crater_radius_m, &w.largest_rock_radius_m, &w.smallest_rock_radius_m, &w.boulder_field_radius_m,
        &w.outcrop_radius_m, &w.dune_height_m, &w.dune_wavelength_m, &w.channel_depth_m, &w.channel_width_m,
        &w.channel_spacing_m, &w.terrace_step_m}) {
    *length *= factor;
  }
}

}  // namespace

std::string_view name_of(GroundKind ground) {
  constexpr std::array<std::string_view, 5> names = {"plains", "dunes", "hills", "hazy", "stark"};
  return names[static_cast<std::size_t>(ground)];
}

std::span<const world::FeatureKind> planted_kinds() {
  static constexpr std::array kinds = {world::FeatureKind::crater, world::FeatureKind::outcrop,
                                       world::FeatureKind::scarp, world::FeatureKind::channel,
                                       world::FeatureKind::boulder_field};
  return kinds;
}

std::string_view name_of(world::FeatureKind feature) {
  constexpr std::array<std::string_view, 6> names = {"crater", "boulder field", "rock", "channel", "scarp", "outcrop"};
  return names[static_cast<std::size_t>(feature)];
}

PlantedWorld planted_world(WorldSet set, GroundKind ground, world::FeatureKind feature, std::uint64_t seed) {
  PlantedWorld planted;
  planted.set = set;
  planted.ground = ground;
  planted.feature = feature;
  planted.seed = seed;
  Draw draw(set, mix64(seed * 64 + static_cast<std::uint64_t>(ground) * 8 + static_cast<std::uint64_t>(feature)));
  world::WorldParams& w = planted.world;
  w.seed = draw.seed();
  lay_ground(ground, draw, w);
  planted.background_crater_m = w.largest_crater_radius_m;
  plant(feature, draw, w);

  planted.effects = world::realistic_effects();
  planted.effects.gain = draw.within({0.7, 1.4}, {0.6, 1.6});
  planted.effects.read_noise_grey = draw.within({0.5, 1.5}, {0.5, 2});
  planted.effects.haze = draw.within({0, 0.15}, {0, 0.2});
  if (ground == GroundKind::hazy) {
    planted.effects.haze = draw.within({0.3, 0.45}, {0.25, 0.5});
    planted.effects.read_noise_grey = draw.within({1, 2}, {1, 2.2});
  }

  CameraModel& camera = planted.camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = draw.within({275, 275}, {250, 310});
  camera.cx = 159.5;
  camera.cy = 119.5;
  camera.k1 = draw.within({0, 0}, {-0.1, 0.05});
  planted.altitude_m = draw.within({100, 100}, {70, 300});
  planted.background_crater_m *= planted.altitude_m / 100;
  scale_lengths(planted.altitude_m / 100, w);
  return planted;
}

}  // namespace ilp::richness
