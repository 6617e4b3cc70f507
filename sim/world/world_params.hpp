// What a simulated world looks like. The defaults suit a camera of 0.1 to 0.3 m ground pixels; another altitude needs
// the lengths scaled with it, as the presets do (world_preset).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/world/parameter.hpp"

namespace ilp::world {

struct WorldParams {
  std::uint64_t seed = 1;  ///< another seed is another place
  double ruggedness = 1;   ///< factor on every height: 0 is the plane z = 0 with its brightness kept

  // Fractal ground: octaves of gradient noise, amplitude proportional to wavelength^hurst
  double relief_m = 12;                ///< typical highest minus lowest point of a flight
  double longest_wavelength_m = 160;   ///< of the fractal ground
  double shortest_wavelength_m = 0.6;  ///< of the fractal ground; at least two post spacings
  double hurst = 0.85;                 ///< 1: equally steep at every scale, lower: rougher
  double post_spacing_m = 0.2;         ///< the ground is bilinear between posts

  // Craters: size classes, each half as large as the previous class
  double largest_crater_radius_m = 18;
  double smallest_crater_radius_m = 1.2;
  double crater_density = 0.6;      ///< 0 to 1: chance of one in a square of 3.2 radii, for the most crowded size
  double crater_size_exponent = 2;  ///< b: the number larger than r falls as r^-b

  // Rocks
  double largest_rock_radius_m = 1.4;
  double smallest_rock_radius_m = 0.35;
  double rock_density = 0.5;  ///< 0 to 1: chance of one in a square of 6 radii, where the ground is rocky
  double rock_size_exponent = 2;
  double boulder_field_radius_m = 15;
  double boulder_field_density = 0;       ///< 0 to 1: chance of one in a square of 4 radii
  double boulder_field_rock_density = 1;  ///< rock_density within them
  int boulder_field_layers = 1;           ///< factor on the number of rocks within them

  // Outcrops of bedrock
  double outcrop_radius_m = 14;
  double outcrop_density = 0;  ///< 0 to 1: chance of one in a square of 4 radii

  // Transverse dunes or ripples
  double dune_height_m = 0;  ///< trough to crest; 0: none
  double dune_wavelength_m = 20;
  double dune_direction_rad = 0.4;  ///< the wind blows towards it, from x towards y; the steep side faces it
  double dune_asymmetry = 0.6;      ///< 0: both sides alike, 1: the steep side is a ninth as long as the other

  // Channels, meandering side by side
  double channel_depth_m = 0;  ///< 0: none
  double channel_width_m = 12;
  double channel_spacing_m = 120;
  double channel_direction_rad = 1.3;
  double channel_meander = 0.5;  ///< 0: straight, 1: as wide as the spacing allows

  // Layers: the fractal ground weathers to terraces with scarps between them
  double terrace_step_m = 0;  ///< between terraces; 0: none
  double terrace_steepness = 0.7;

  // Shore: the ground falls away on one side of a line, and liquid fills what lies low
  double shore_slope = 0;               ///< of the ground across the line; 0: none
  double shore_direction_rad = 1.5708;  ///< towards the land, across the line
  double shore_distance_m = 0;          ///< from the origin to the line, along the direction
  bool liquid = false;
  double liquid_level_m = 0;  ///< height of its surface
  double liquid_albedo = 0.3;

  // Imported ground: GeoTIFF, PFM or PNG; empty: none
  std::string heightmap;             ///< replaces everything above that has a height, but liquid
  bool heightmap_landforms = false;  ///< craters, rocks, dunes, channels and terraces on the imported heights too
  std::string albedo_map;            ///< replaces the generated brightness; its mean becomes 1
  double map_spacing_m = 0;          ///< between the pixels of the maps; 0: the file says it
  double map_height_unit_m = 1;      ///< metres per unit of the heightmap
  double map_x_m = 0;                ///< where the centre of the heightmap lies
  double map_y_m = 0;
  bool map_georeferenced = false;  ///< the file's own coordinates and heights; else its mean height is z = 0
  bool fill_holes = false;         ///< pixels without a height get one from their neighbours; else they are an error

  // Light and surface
  double sun_azimuth_rad = 2.2;     ///< direction towards the sun, from x towards y
  double sun_elevation_rad = 0.55;  ///< above the horizon
  double ambient = 0.25;            ///< share of the light on level ground that comes from the whole sky
  double albedo_contrast = 0.6;     ///< strength of the surface's brightness variations
};

/// The fields by name, for scenario files and campaigns.
[[nodiscard]] std::vector<Parameter> parameters(WorldParams& world);

/// std::invalid_argument names the field that is out of its range or contradicts another, and what was expected.
void validate(const WorldParams& world);

// Worlds by name, each with the flight that suits its lengths: a ground pixel is about a post for a camera of 550 px
// focal length.

struct WorldPreset {
  std::string_view name;
  std::string_view meaning;
  WorldParams world;
  double altitude_m = 100;
  double drift_m_s = 2.5;  ///< along x: 95 % overlap between frames taken every 2 s
};

/// testbed, mars-plains, mars-canyon, titan-shore, flat.
[[nodiscard]] std::span<const WorldPreset> world_presets();

/// std::invalid_argument lists the names.
[[nodiscard]] const WorldPreset& world_preset(std::string_view name);

}  // namespace ilp::world
