// ilp-lab world-map: a simulated world as the tiles of a map.
#include <cmath>
#include <fstream>
#include <memory>
#include <numbers>
#include <vector>

#include "fsw/maps/map_tile.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"
#include "tests/integration/lab_program.hpp"

namespace ilp::test {
namespace {

class LabWorldMap : public LabTest {
 protected:
  /// Decodes every tile of the map in the folder "map".
  void read(MapDirectory& directory, std::vector<std::unique_ptr<MapTile>>& tiles) const {
    DirectoryMapSource source;
    ASSERT_TRUE(source.open(path("map").c_str()).ok());
    std::vector<std::uint8_t> bytes(max_map_directory_bytes);
    std::size_t size = 0;
    ASSERT_TRUE(source.read_directory(bytes, size).ok());
    ASSERT_TRUE(parse_map_directory(std::span(bytes).first(size), {}, directory).ok());
    const auto workspace = std::make_unique<MapTileWorkspace>();
    for (std::size_t i = 0; i < directory.tiles.size(); ++i) {
      const MapTileEntry& entry = directory.tiles[i];
      ASSERT_TRUE(source.read_tile({entry.layer, entry.row, entry.column}, bytes, size).ok());
      tiles.push_back(std::make_unique<MapTile>());
      ASSERT_TRUE(decode_map_tile(std::span(bytes).first(size), directory, i, *workspace, *tiles.back()).ok());
    }
  }
};

TEST_F(LabWorldMap, HeightsOfBothLayersAreThoseOfTheWorld) {
  lab_done("world-map mars-plains --pixel 1 --area -100,-60,300,200 --sun 200,40 --height-sigma 0 --out " +
           path("map"));
  const auto directory = std::make_unique<MapDirectory>();
  std::vector<std::unique_ptr<MapTile>> tiles;
  read(*directory, tiles);
  ASSERT_EQ(directory->layer_count, 2U);
  EXPECT_EQ(directory->layers[0].x0_m, -100);
  EXPECT_EQ(directory->layers[0].y0_m, 200);
  EXPECT_EQ(directory->layers[1].pixel_m, 4);
  EXPECT_EQ(directory->body, Body::none);
  EXPECT_NEAR(directory->sun_azimuth_rad, -110 * std::numbers::pi / 180, 1e-9) << "from x to y";
  EXPECT_NEAR(directory->sun_elevation_rad, 40 * std::numbers::pi / 180, 1e-9);
  const world::Terrain terrain(world::scenario_preset("mars-plains").world);
  ASSERT_EQ(tiles.size(), 2U * 2U + 1U);
  for (const auto& tile : tiles) {
    const MapLayer& layer = directory->layers[tile->layer];
    const double box = 4 * layer.pixel_m;
    for (const auto& [i, j] : {std::pair{0, 0}, {64, 64}, {30, 11}, {64, 0}}) {
      const double x = layer.x0_m + (tile->column * 256 + 4 * i) * layer.pixel_m;
      const double y = layer.y0_m - (tile->row * 256 + 4 * j) * layer.pixel_m;
      double sum = 0;
      for (int b = 0; b < 32; ++b) {
        for (int a = 0; a < 32; ++a)
          sum += terrain.height(x + ((a + 0.5) / 32 - 0.5) * box, y + ((b + 0.5) / 32 - 0.5) * box);
      }
      ASSERT_TRUE(tile->is_known(i, j));
      EXPECT_NEAR(tile->height_m(i, j), sum / 1024, tile->height_step_m / 2 + 0.03)
          << tile->layer << " " << i << " " << j;
    }
  }
}

// Bytes of image and heights per km2 as docs/map-relative.md has them, within a factor of 1.5.
TEST_F(LabWorldMap, TilesTakeTheBytesThatThePageStates) {
  struct Case {
    const char* world;
    double per_km2;
  };
  for (const Case& c : {Case{"mars-plains --pixel 0.82 --area -150,-150,269,59", 170e3},
                        Case{"mars-canyon --pixel 2.5 --area -450,-400,829,239", 20e3}}) {
    const LabRun run = lab_done(std::string("world-map ") + c.world + " --features 0 --coarse 1 --out " + path("map"));
    const auto& layer = run.json.at("layers")[0];
    const double per_km2 = layer.at("bytes").get<double>() / layer.at("km2").get<double>();
    EXPECT_LT(per_km2, 1.5 * c.per_km2) << c.world;
    EXPECT_GT(per_km2, c.per_km2 / 1.5) << c.world;
  }
}

TEST_F(LabWorldMap, TheSameWorldGivesTheSameMapAndAnotherSunAnotherImage) {
  const std::string command = "world-map mars-plains --pixel 2 --coarse 1 --area 0,0,400,400 --out " + path("map");
  const LabRun first = lab_done(command);
  EXPECT_EQ(lab(command).json.at("map"), first.json.at("map"));
  const LabRun turned = lab(command + " --sun-turn 90");
  EXPECT_NE(turned.json.at("map"), first.json.at("map"));
  EXPECT_NEAR(std::remainder(turned.number("sun_azimuth_rad") - first.number("sun_azimuth_rad"), 2 * std::numbers::pi),
              std::numbers::pi / 2, 1e-9);
}

TEST_F(LabWorldMap, WhatIsWrongIsNamed) {
  const auto refused = [&](const std::string& arguments, const char* words) {
    const LabRun run = lab("world-map " + arguments + " --out " + path("map"));
    EXPECT_NE(run.status, 0);
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  };
  refused("mars-plains --pixel 1 --area 10,0,0,10", "--area is empty");
  refused("mars-plains --pixel 1 --area 0,0,10,10 --sun 10,-5", "the sun must be above the horizon");
  refused("nowhere --pixel 1 --area 0,0,10,10", "nowhere");
  refused("mars-plains --pixel 0.02 --area 0,0,10,10", "below half a post");
  refused("mars-plains --pixel 1 --area 0,0,1000000,1000000", "choose a smaller --area or a larger --pixel");
}

}  // namespace
}  // namespace ilp::test
