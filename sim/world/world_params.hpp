// Parameters of a simulated world. The defaults suit ground pixels of 0.1 to 0.3 m. For another altitude all lengths
// must be scaled, as in the presets (world_preset).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/world/parameter.hpp"

namespace ilp::world {

struct WorldParams {
  std::uint64_t seed = 1;  ///< another seed gives other ground
  double ruggedness = 1;   ///< factor on every height; 0: the plane z = 0 with the same brightness

  // Fractal ground: octaves of gradient noise with amplitudes proportional to wavelength^hurst
  double relief_m = 12;                ///< typical difference between highest and lowest point below a flight
  double longest_wavelength_m = 160;   ///< of the fractal ground
  double shortest_wavelength_m = 0.6;  ///< of the fractal ground; at least two post spacings
  double hurst = 0.85;                 ///< 1: equally steep at every scale; lower: rougher
  double post_spacing_m = 0.2;         ///< between posts, where heights are computed; bilinear in between

  // Craters: size classes, each half as large as the class before
  double largest_crater_radius_m = 18;
  double smallest_crater_radius_m = 1.2;
  double crater_density = 0.6;      ///< 0 to 1: probability per square of 3.2 radii, for the most crowded class
  double crater_size_exponent = 2;  ///< b: the number with radii above r is proportional to r^-b

  // Rocks
  double largest_rock_radius_m = 1.4;
  double smallest_rock_radius_m = 0.35;
  double rock_density = 0.5;      ///< 0 to 1: probability per square of 6 radii, on rocky ground
  double rock_size_exponent = 2;  ///< as crater_size_exponent
  double boulder_field_radius_m = 15;
  double boulder_field_density = 0;       ///< 0 to 1: probability per square of 4 radii
  double boulder_field_rock_density = 1;  ///< rock_density inside boulder fields
  int boulder_field_layers = 1;           ///< factor on the number of rocks inside boulder fields

  // Outcrops of bedrock
  double outcrop_radius_m = 14;
  double outcrop_density = 0;  ///< 0 to 1: probability per square of 4 radii

  // Transverse dunes or ripples
  double dune_height_m = 0;  ///< trough to crest; 0: none
  double dune_wavelength_m = 20;
  double dune_direction_rad = 0.4;  ///< to which the wind blows and the steep side faces, from x towards y
  double dune_asymmetry = 0.6;      ///< 0: both sides equal; 1: the steep side is a ninth as long as the other

  // Parallel, meandering channels
  double channel_depth_m = 0;  ///< 0: none
  double channel_width_m = 12;
  double channel_spacing_m = 120;      ///< between centre lines
  double channel_direction_rad = 1.3;  ///< along the channels, from x towards y
  double channel_meander = 0.5;        ///< 0: straight; 1: as wide as the spacing allows

  // Layers: the fractal ground has terraces with scarps between them
  double terrace_step_m = 0;       ///< height between terraces; 0: none
  double terrace_steepness = 0.7;  ///< 0 to 1 (terrace in landforms.hpp)

  // Shore: the ground slopes down on one side of a line, and liquid covers low ground
  double shore_slope = 0;               ///< of the ground across the line; 0: no shore
  double shore_direction_rad = 1.5708;  ///< towards the land, across the line
  double shore_distance_m = 0;          ///< from the origin to the line, along the direction
  bool liquid = false;                  ///< there is liquid
  double liquid_level_m = 0;            ///< height of the liquid's surface
  double liquid_albedo = 0.3;

  // Imported ground: files in GeoTIFF, PFM or PNG; empty: none
  std::string heightmap;             ///< replaces all generated heights except the liquid
  bool heightmap_landforms = false;  ///< adds craters, rocks, dunes, channels and terraces to the imported heights
  std::string albedo_map;            ///< replaces the generated brightness; its mean becomes 1
  double map_spacing_m = 0;          ///< between the pixels of the maps; 0: from the file
  double map_height_unit_m = 1;      ///< factor on the heights that were read
  double map_x_m = 0;                ///< position of the heightmap's centre
  double map_y_m = 0;
  bool map_georeferenced = false;  ///< uses the file's coordinates and heights; else its mean height becomes z = 0
  bool fill_holes = false;         ///< fills pixels without a value from their neighbours; else they are an error

  // Light and surface
  double sun_azimuth_rad = 2.2;     ///< direction towards the sun, from x towards y
  double sun_elevation_rad = 0.55;  ///< above the horizon
  double ambient = 0.25;            ///< share of the light on level ground that comes from the whole sky
  double albedo_contrast = 0.6;     ///< strength of the surface's brightness variations
};

/// The fields by name, for scenario files and campaigns.
[[nodiscard]] std::vector<Parameter> parameters(WorldParams& world);

/// Throws std::invalid_argument that names a field that is out of range or contradicts another field, and what was
/// expected.
void validate(const WorldParams& world);

// Preset worlds, each with altitude and speed of a flight that suits its lengths. For a focal length of 550 px, a
// ground pixel is about as large as the post spacing.

struct WorldPreset {
  std::string_view name;
  std::string_view meaning;  ///< for the list of scenarios
  WorldParams world;
  double altitude_m = 100;
  double drift_m_s = 2.5;  ///< along x: 95 % overlap between frames taken every 2 s
};

/// The presets testbed, mars-plains, mars-canyon, titan-shore and flat.
[[nodiscard]] std::span<const WorldPreset> world_presets();

/// The preset with this name. Throws std::invalid_argument with a list of the names if there is none.
[[nodiscard]] const WorldPreset& world_preset(std::string_view name);

}  // namespace ilp::world
