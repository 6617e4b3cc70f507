// world-map: renders an orbiter's map of a simulated world.

#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>

#include "sim/ground/maps/map_writer.hpp"
#include "sim/host/key_file.hpp"
#include "sim/tools/lab/lab.hpp"
#include "sim/world/orbital_map.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::lab {
namespace {

constexpr double radians = std::numbers::pi / 180;
constexpr std::int32_t block = 64;  // of render_orbital_map

struct WorldMapOptions {
  std::string scenario = std::string(world::default_scenario), body;
  std::vector<std::string> set;
  std::vector<double> area, sun, origin;
  double sun_turn_deg = 0, height_sigma_px = 0.3, place_sigma_m = 0;
  int coarse = 4;
  world::OrbitalMapParams map;
  maps::TileParams tiles;
  bool as_imaged = false;
  std::string key, out;
};

/// The world under the sun of the map.
world::WorldParams world_of(const WorldMapOptions& options, world::Scenario& scenario) {
  world::WorldParams world = scenario.world;
  if (!options.sun.empty()) {
    world.sun_azimuth_rad = std::remainder((90 - options.sun[0]) * radians, 2 * std::numbers::pi);
    world.sun_elevation_rad = options.sun[1] * radians;
  }
  world.sun_azimuth_rad = std::remainder(world.sun_azimuth_rad + options.sun_turn_deg * radians, 2 * std::numbers::pi);
  if (!(world.sun_elevation_rad > 0 && world.sun_elevation_rad <= std::numbers::pi / 2)) {
    throw UsageError("the sun must be above the horizon, at most 90 degrees: --sun AZIMUTH,ELEVATION");
  }
  return world;
}

MapDirectory& fill_directory(const WorldMapOptions& options, const world::WorldParams& world, MapDirectory& directory) {
  if (!options.body.empty()) {
    directory.body = static_cast<Body>(find_value(values_of(Body{}), options.body.c_str())->number);
  }
  if (!options.origin.empty()) {
    directory.longitude_rad = options.origin[0] * radians;
    directory.latitude_rad = options.origin[1] * radians;
  }
  directory.sun_azimuth_rad = world.sun_azimuth_rad;
  directory.sun_elevation_rad = world.sun_elevation_rad;
  directory.ambient = world.ambient;
  directory.image_sigma = options.map.noise * 128;
  directory.height_sigma_m = options.height_sigma_px * options.map.pixel_m;
  directory.place_sigma_m = options.place_sigma_m;
  const double west = options.area[0], south = options.area[1], east = options.area[2], north = options.area[3];
  maps::set_layers(directory, west, north, east - west, north - south, options.map.pixel_m, options.coarse);
  return directory;
}

/// The rendered map in pieces: those of the coarse layer are means of it.
class RenderedPatches {
 public:
  RenderedPatches(const world::Terrain& terrain, const MapDirectory& directory, const world::OrbitalMapParams& params)
      : factor_(directory.layer_count > 1
                    ? static_cast<std::int32_t>(std::lround(directory.layers[1].pixel_m / params.pixel_m))
                    : 1) {
    const MapLayer& layer = directory.layers[0];
    const MapLayer& largest = directory.layers[directory.layer_count - 1];
    const auto cells = [&](std::int32_t tiles) {
      const std::int32_t all = (tiles * map_tile_side + 2 * maps::tile_margin + 2 * map_post_spacing) * factor_;
      return (all + block - 1) / block * block;
    };
    margin_ = (maps::tile_margin + map_post_spacing) * factor_;
    map_ =
        world::render_orbital_map(terrain, layer.x0_m - margin_ * params.pixel_m, layer.y0_m + margin_ * params.pixel_m,
                                  cells(largest.columns), cells(largest.rows), params);
  }

  [[nodiscard]] maps::MapPatch operator()(const MapLayer& layer, const maps::PatchArea& area, double finest_m) const {
    const std::int32_t factor = layer.pixel_m > 1.5 * finest_m ? factor_ : 1;
    maps::MapPatch patch;
    patch.light = host::Raster<float>(area.columns, area.rows);
    for (std::int32_t y = 0; y < area.rows; ++y) {
      for (std::int32_t x = 0; x < area.columns; ++x) {
        patch.light.at(x, y) = mean(map_.light, (area.first_column + x) * factor + margin_,
                                    (area.first_row + y) * factor + margin_, factor);
      }
    }
    patch.posts = host::Raster<float>(area.columns / map_post_spacing + 1, area.rows / map_post_spacing + 1);
    for (std::int32_t j = 0; j < patch.posts.height; ++j) {
      for (std::int32_t i = 0; i < patch.posts.width; ++i) {
        patch.posts.at(i, j) =
            post((area.first_column / map_post_spacing + i) * factor + margin_ / map_post_spacing,
                 (area.first_row / map_post_spacing + j) * factor + margin_ / map_post_spacing, factor);
      }
    }
    return patch;
  }

 private:
  static float mean(const host::Raster<float>& values, std::int32_t column, std::int32_t row, std::int32_t side) {
    double sum = 0;
    for (std::int32_t y = 0; y < side; ++y) {
      for (std::int32_t x = 0; x < side; ++x) sum += double{values.at(column + x, row + y)};
    }
    return static_cast<float>(sum / (side * side));
  }
  /// Mean over the square of `side` post spacings about a post: the outermost posts count half.
  [[nodiscard]] float post(std::int32_t i, std::int32_t j, std::int32_t side) const {
    if (side == 1) return map_.heights.at(i, j);
    double sum = 0, weights = 0;
    const std::int32_t reach = side / 2;
    for (std::int32_t dj = -reach; dj <= reach; ++dj) {
      for (std::int32_t di = -reach; di <= reach; ++di) {
        const double weight = (2 * std::abs(di) == side ? 0.5 : 1) * (2 * std::abs(dj) == side ? 0.5 : 1);
        sum += weight * double{map_.heights.at(i + di, j + dj)};
        weights += weight;
      }
    }
    return static_cast<float>(sum / weights);
  }

  std::int32_t factor_, margin_ = 0;
  world::OrbitalMap map_;
};

Json run_world_map(WorldMapOptions options) {
  std::vector<world::ScenarioEntry> overrides;
  for (const std::string& text : options.set) overrides.push_back(world::parse_override(text));
  world::Scenario scenario = world::load_scenario(options.scenario, overrides);
  if (!(options.area[0] < options.area[2] && options.area[1] < options.area[3])) {
    throw UsageError("--area is empty: WEST,SOUTH,EAST,NORTH with west below east and south below north expected");
  }
  const world::WorldParams world = world_of(options, scenario);
  const world::Terrain terrain(world);
  const auto directory = std::make_unique<MapDirectory>();
  fill_directory(options, world, *directory);
  options.map.height_sigma_m = directory->height_sigma_m;
  options.tiles.sun = {world.sun_azimuth_rad, world.sun_elevation_rad, world.ambient};
  options.tiles.flight_sun = maps::Sun{scenario.world.sun_azimuth_rad, scenario.world.sun_elevation_rad, world.ambient};
  options.tiles.flat = !options.as_imaged;
  const RenderedPatches patches(terrain, *directory, options.map);
  const std::vector<std::uint8_t> key =
      options.key.empty() ? std::vector<std::uint8_t>{} : host::read_key_file(options.key).octets;
  const maps::MapSummary summary = maps::write_map(
      *directory,
      [&](const MapLayer& layer, const maps::PatchArea& area) { return patches(layer, area, options.map.pixel_m); },
      options.tiles, key, options.out, std::cerr);
  Json layers = Json::array();
  for (const maps::LayerSummary& layer : summary.layers) {
    layers.push_back(
        {{"pixel_m", layer.pixel_m}, {"tiles", layer.tiles}, {"bytes", layer.bytes}, {"km2", layer.known_km2}});
  }
  return {{"map", summary.id},
          {"layers", layers},
          {"directory_bytes", summary.directory_bytes},
          {"sun_azimuth_rad", world.sun_azimuth_rad},
          {"sun_elevation_rad", world.sun_elevation_rad}};
}

void add_light(CLI::App& app, WorldMapOptions& options) {
  app.add_option("--sun", options.sun, "AZIMUTH,ELEVATION of the sun of the map, degrees clockwise from y (north)")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--sun-turn", options.sun_turn_deg, "turns the sun of the scenario, or that of --sun, degrees")
      ->check(finite_in(-360, 360));
  app.add_option("--spread", options.map.spread_px, "sigma of the point spread, pixels")->check(finite_in(0, 0.8));
  app.add_option("--noise", options.map.noise, "noise of the image as a share of the light on level ground")
      ->check(finite_in(0, 1));
  app.add_option("--map-seed", options.map.seed, "seed of the errors of the map");
  app.add_option("--height-sigma", options.height_sigma_px, "smooth error of the heights, one sigma, pixels")
      ->check(finite_in(0, 100));
  app.add_option("--place-sigma", options.place_sigma_m, "estimated error of the place of the whole map, m")
      ->check(finite_in(0, 1e6));
}

}  // namespace

void add_world_map_command(Lab& lab) {
  const auto options = std::make_shared<WorldMapOptions>();
  CLI::App& app = lab.add(
      "world-map", "makes the map that an orbiter would have made of a simulated world, for a flight to carry",
      "mars-plains --area=-500,-500,1500,1500 --pixel 2 --out map", [options](int) { return run_world_map(*options); });
  app.add_option("SCENARIO", options->scenario, "preset or scenario file");
  app.add_option("--set", options->set, "section.name=value: another value of the scenario");
  app.add_option("--area", options->area, "WEST,SOUTH,EAST,NORTH of the world, m")
      ->required()
      ->delimiter(',')
      ->expected(4);
  app.add_option("--pixel", options->map.pixel_m, "metres per pixel")->required()->check(finite_in(1e-3, 1e5));
  app.add_option("--coarse", options->coarse,
                 "ratio of the pixel size of the second layer to that of the first; 1: no second layer")
      ->check(CLI::Range(1, 16));
  add_light(app, *options);
  app.add_option("--body", options->body, "body that the map states")
      ->check(CLI::IsMember({"mars", "titan", "venus", "moon", "earth"}));
  app.add_option("--origin", options->origin, "LONGITUDE,LATITUDE of the world's origin, degrees")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--features", options->tiles.features, "features of a tile")
      ->check(CLI::Range(std::size_t{0}, limits::max_map_features));
  app.add_option("--image-bits", options->tiles.image_bits, "bits per pixel of the image")->check(finite_in(0.05, 4));
  app.add_flag("--as-imaged", options->as_imaged, "leave the light of the image as it is");
  app.add_option("--key", options->key, "file of keys of the flight; the directory is signed with its first key");
  app.add_option("--out", options->out, "folder for the map")->required();
}

}  // namespace ilp::lab
