#include "sim/world/world_params.hpp"

#include <array>
#include <stdexcept>
#include <string>

namespace ilp::world {
namespace {

void require(bool right, const char* field, const char* expected) {
  if (!right) throw std::invalid_argument(std::string("[world] ") + field + ": must be " + expected);
}

constexpr double longest = 1e5;  // m
constexpr double turn = 6.283185307179587;

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

std::vector<Parameter> parameters(WorldParams& w) {
  return {
      {"seed", &w.seed, "", "seed of the ground: another seed makes another place"},
      {"ruggedness", &w.ruggedness, "", "factor on every height; 0 is perfectly flat", 0, 3},
      {"relief_m", &w.relief_m, "m", "typical highest minus lowest point of a flight", 1e-6, longest},
      {"longest_wavelength_m", &w.longest_wavelength_m, "m", "longest wavelength of the fractal ground", 1e-3, 1e6},
      {"shortest_wavelength_m", &w.shortest_wavelength_m, "m",
       "shortest wavelength of the fractal ground, at least two post spacings", 1e-3, 1e6},
      {"hurst", &w.hurst, "", "Hurst exponent of the ground; 1: equally steep at every scale, lower: rougher", 0, 2},
      {"post_spacing_m", &w.post_spacing_m, "m", "spacing of the heights, about a ground pixel", 1e-4, 1e4},
      {"largest_crater_radius_m", &w.largest_crater_radius_m, "m", "radius of the largest crater", 1e-4, longest},
      {"smallest_crater_radius_m", &w.smallest_crater_radius_m, "m", "radius of the smallest crater", 1e-4, longest},
      {"crater_density", &w.crater_density, "", "chance of a crater in a square of 3.2 radii; 0: no craters", 0, 1},
      {"crater_size_exponent", &w.crater_size_exponent, "", "b: the number of craters larger than r falls as r^-b", 0.5,
       6},
      {"largest_rock_radius_m", &w.largest_rock_radius_m, "m", "radius of the largest rock", 1e-4, longest},
      {"smallest_rock_radius_m", &w.smallest_rock_radius_m, "m", "radius of the smallest rock", 1e-4, longest},
      {"rock_density", &w.rock_density, "", "chance of a rock in a square of 6 radii, where the ground is rocky", 0, 1},
      {"rock_size_exponent", &w.rock_size_exponent, "", "b: the number of rocks larger than r falls as r^-b", 0.5, 6},
      {"boulder_field_radius_m", &w.boulder_field_radius_m, "m", "radius of a boulder field", 1e-3, longest},
      {"boulder_field_density", &w.boulder_field_density, "",
       "chance of a boulder field in a square of 4 radii; 0: none", 0, 1},
      {"boulder_field_rock_density", &w.boulder_field_rock_density, "", "rock_density within a boulder field", 0, 1},
      {"boulder_field_layers", &w.boulder_field_layers, "", "factor on the number of rocks within a boulder field", 1,
       8},
      {"outcrop_radius_m", &w.outcrop_radius_m, "m", "radius of the largest outcrop", 1e-3, longest},
      {"outcrop_density", &w.outcrop_density, "", "chance of an outcrop in a square of 4 radii; 0: none", 0, 1},
      {"dune_height_m", &w.dune_height_m, "m", "height of dunes from trough to crest; 0: no dunes", 0, longest},
      {"dune_wavelength_m", &w.dune_wavelength_m, "m", "distance between two crests", 1e-3, longest},
      {"dune_direction_rad", &w.dune_direction_rad, "rad", "direction towards which the wind blows", -turn, turn},
      {"dune_asymmetry", &w.dune_asymmetry, "", "0: both sides alike, 1: steepest lee side", 0, 1},
      {"channel_depth_m", &w.channel_depth_m, "m", "depth of channels; 0: no channels", 0, longest},
      {"channel_width_m", &w.channel_width_m, "m", "width of a channel", 1e-3, longest},
      {"channel_spacing_m", &w.channel_spacing_m, "m", "distance between channels, at least three widths", 1e-3, 1e6},
      {"channel_direction_rad", &w.channel_direction_rad, "rad", "direction of the channels", -turn, turn},
      {"channel_meander", &w.channel_meander, "", "0: straight, 1: as wide as the spacing allows", 0, 1},
      {"terrace_step_m", &w.terrace_step_m, "m", "height between layers; 0: none", 0, longest},
      {"terrace_steepness", &w.terrace_steepness, "", "steepness of the scarps; 0: as the ground was, 1: cliffs", 0, 1},
      {"shore_slope", &w.shore_slope, "", "slope of the ground across the shore; 0: no shore", 0, 10},
      {"shore_direction_rad", &w.shore_direction_rad, "rad", "direction towards the land", -turn, turn},
      {"shore_distance_m", &w.shore_distance_m, "m", "distance from the origin to the shore, along its direction", -1e6,
       1e6},
      {"liquid", &w.liquid, "", "liquid fills the ground below liquid_level_m"},
      {"liquid_level_m", &w.liquid_level_m, "m", "height of the surface of the liquid", -longest, longest},
      {"liquid_albedo", &w.liquid_albedo, "", "brightness of the liquid; 1 is mean ground", 0.01, 3},
      {"heightmap", &w.heightmap, "", "GeoTIFF, PFM or PNG file of heights; empty: the ground is generated"},
      {"heightmap_landforms", &w.heightmap_landforms, "",
       "imported heights get craters, rocks and other landforms too"},
      {"albedo_map", &w.albedo_map, "", "GeoTIFF, PFM or PNG file of brightness; empty: brightness is generated"},
      {"map_spacing_m", &w.map_spacing_m, "m", "distance between the pixels of the maps; 0: as the file says", 0, 1e4},
      {"map_height_unit_m", &w.map_height_unit_m, "m", "metres per unit of the heightmap", 1e-9, 1e6},
      {"map_x_m", &w.map_x_m, "m", "x of the centre of the heightmap", -1e6, 1e6},
      {"map_y_m", &w.map_y_m, "m", "y of the centre of the heightmap", -1e6, 1e6},
      {"map_georeferenced", &w.map_georeferenced, "", "the coordinates and heights of the file are used as they are"},
      {"fill_holes", &w.fill_holes, "", "pixels without a height get one from their neighbours"},
      {"sun_azimuth_rad", &w.sun_azimuth_rad, "rad", "azimuth of the sun, from x towards y", -turn, turn},
      {"sun_elevation_rad", &w.sun_elevation_rad, "rad", "elevation of the sun above the horizon", 0.05, 1.58},
      {"ambient", &w.ambient, "", "share of the light on level ground that comes from the sky", 0, 1},
      {"albedo_contrast", &w.albedo_contrast, "", "strength of brightness variations", 0, 1},
  };
}

namespace {

void check_relief(const WorldParams& w) {
  require(w.shortest_wavelength_m >= 2 * w.post_spacing_m, "shortest_wavelength_m", "at least two post spacings");
  require(w.longest_wavelength_m >= w.shortest_wavelength_m, "longest_wavelength_m", "at least shortest_wavelength_m");
}

void check_landforms(const WorldParams& w) {
  if (w.crater_density > 0) {
    require(w.smallest_crater_radius_m >= w.post_spacing_m, "smallest_crater_radius_m", "at least one post spacing");
    require(w.largest_crater_radius_m >= w.smallest_crater_radius_m, "largest_crater_radius_m",
            "at least smallest_crater_radius_m");
  }
  if (w.rock_density > 0 || w.boulder_field_density > 0) {
    require(w.smallest_rock_radius_m >= w.post_spacing_m, "smallest_rock_radius_m", "at least one post spacing");
    require(w.largest_rock_radius_m >= w.smallest_rock_radius_m, "largest_rock_radius_m",
            "at least smallest_rock_radius_m");
  }
  if (w.boulder_field_density > 0) {
    require(w.boulder_field_radius_m >= w.largest_rock_radius_m, "boulder_field_radius_m",
            "at least largest_rock_radius_m");
  }
  if (w.outcrop_density > 0) {
    require(w.outcrop_radius_m >= 8 * w.post_spacing_m, "outcrop_radius_m", "at least eight post spacings");
  }
  if (w.dune_height_m > 0) {
    require(w.dune_wavelength_m >= 6 * w.post_spacing_m, "dune_wavelength_m", "at least six post spacings");
    require(w.dune_height_m <= w.dune_wavelength_m, "dune_height_m", "at most dune_wavelength_m");
  }
  if (w.channel_depth_m > 0) {
    require(w.channel_width_m >= 4 * w.post_spacing_m, "channel_width_m", "at least four post spacings");
    require(w.channel_spacing_m >= 3 * w.channel_width_m, "channel_spacing_m", "at least three channel_width_m");
  }
  if (w.terrace_step_m > 0) {
    require(w.terrace_step_m >= 1e-3 * w.relief_m, "terrace_step_m", "at least a thousandth of relief_m");
  }
}

}  // namespace

void validate(const WorldParams& world) {
  WorldParams w = world;
  check_parameters(parameters(w), "world");
  // A height map brings its relief, and its landforms unless more are wanted.
  if (w.heightmap.empty()) check_relief(w);
  if (w.heightmap.empty() || w.heightmap_landforms) check_landforms(w);
  require(w.heightmap.empty() || !w.map_georeferenced || (w.map_x_m == 0 && w.map_y_m == 0), "map_x_m, map_y_m",
          "0 where map_georeferenced says that the file knows its place");
}

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
