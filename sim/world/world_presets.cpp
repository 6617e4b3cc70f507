#include "sim/world/world_presets.hpp"

#include <array>
#include <stdexcept>
#include <string>

namespace ilp::world {
namespace {

/// Raked sand with ripples and stones on it, a few metres wide, seen from a mast.
WorldPreset testbed() {
  WorldPreset preset{"testbed", "near-planar sand with ripples and rocks, seen from 2 to 10 m", {}, 5, 0.125};
  WorldParams& w = preset.world;
  w.post_spacing_m = 0.01;
  w.relief_m = 0.12;
  w.longest_wavelength_m = 6;
  w.shortest_wavelength_m = 0.03;
  w.hurst = 0.9;
  w.crater_density = 0;
  w.largest_rock_radius_m = 0.24;
  w.smallest_rock_radius_m = 0.015;
  w.rock_density = 0.35;
  w.dune_height_m = 0.02;
  w.dune_wavelength_m = 0.25;
  w.dune_asymmetry = 0.4;
  return preset;
}

WorldPreset mars_plains() {
  WorldPreset preset{"mars-plains", "cratered plains with rocks and boulder fields, from 100 m", {}, 100, 2.5};
  preset.world.boulder_field_density = 0.25;
  preset.world.boulder_field_radius_m = 12;
  return preset;
}

WorldPreset mars_canyon() {
  WorldPreset preset{
      "mars-canyon", "layered scarps and terraces, relief of a quarter of the altitude, from 300 m", {}, 300, 7.5};
  WorldParams& w = preset.world;
  w.post_spacing_m = 0.5;
  w.relief_m = 125;
  w.longest_wavelength_m = 420;
  w.shortest_wavelength_m = 1.5;
  w.hurst = 1;
  w.terrace_step_m = 18;
  w.terrace_steepness = 0.75;
  w.largest_crater_radius_m = 24;
  w.smallest_crater_radius_m = 3;
  w.crater_density = 0.15;
  w.largest_rock_radius_m = 4;
  w.smallest_rock_radius_m = 0.8;
  w.rock_density = 0.25;
  w.boulder_field_radius_m = 40;
  w.boulder_field_density = 0.3;
  w.sun_elevation_rad = 0.8;
  return preset;
}

WorldPreset titan_shore() {
  WorldPreset preset{
      "titan-shore", "low hills cut by channels, and the dark liquid that they run into, from 200 m", {}, 200, 5};
  WorldParams& w = preset.world;
  w.post_spacing_m = 0.4;
  w.relief_m = 18;
  w.longest_wavelength_m = 320;
  w.shortest_wavelength_m = 1.2;
  w.hurst = 0.95;
  w.crater_density = 0;
  w.largest_rock_radius_m = 1.6;
  w.smallest_rock_radius_m = 0.6;
  w.rock_density = 0.3;
  w.channel_depth_m = 3;
  w.channel_width_m = 12;
  w.channel_spacing_m = 110;
  w.channel_direction_rad = 1.3;
  w.shore_slope = 0.12;
  w.shore_direction_rad = 1.5708;
  w.shore_distance_m = -50;
  w.liquid = true;
  w.liquid_level_m = -1.5;
  w.sun_elevation_rad = 0.7;
  w.ambient = 0.6;  // light through thick haze
  return preset;
}

WorldPreset flat() {
  WorldPreset preset{"flat", "a perfect plane with brightness of every scale, from 100 m", {}, 100, 2.5};
  preset.world.ruggedness = 0;
  preset.world.albedo_contrast = 0.8;
  return preset;
}

}  // namespace

std::span<const WorldPreset> world_presets() {
  static const std::array<WorldPreset, 5> presets = {testbed(), mars_plains(), mars_canyon(), titan_shore(), flat()};
  return presets;
}

const WorldPreset& world_preset(std::string_view name) {
  std::string names;
  for (const WorldPreset& preset : world_presets()) {
    if (preset.name == name) return preset;
    names += (names.empty() ? "" : ", ") + std::string(preset.name);
  }
  throw std::invalid_argument("world: no preset \"" + std::string(name) + "\"; there are " + names);
}

}  // namespace ilp::world
