// Maps from rasters whose content is known at every longitude and latitude.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "sim/host/files.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/maps/scene.hpp"

namespace ilp::maps {
namespace {
namespace fs = std::filesystem;

using test::RasterFile;
using test::read_map;
using test::ReadMap;
using test::transverse_mercator;
using test::write_raster;

constexpr double mars_m = 3396190, degree_m = mars_m * std::numbers::pi / 180;
constexpr double radians = std::numbers::pi / 180;
const char* const equirectangular = "+proj=eqc +lat_ts=0 +lon_0=0 +R=3396190 +units=m +no_defs";

class MapTiles : public ::testing::Test {
 protected:
  MapTiles() : folder_(fs::temp_directory_path() / ("ilp-map-tiles-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    options_.image = folder_ / "image.tif";
    options_.heights = folder_ / "heights.tif";
    options_.sun_azimuth_deg = 270;
    options_.sun_elevation_deg = 40;
    options_.pixel_m = 5;
    options_.out = folder_ / "map";
  }
  ~MapTiles() override { fs::remove_all(folder_); }

  std::string refusal() {
    std::ostringstream messages;
    return test::error_of([&] { make_map_tiles(options_, messages); });
  }
  /// What ilp-ground map-tiles says.
  std::string run_program(const std::string& arguments, int& status) {
    const fs::path out = folder_ / "said";
    status = WEXITSTATUS(
        std::system((ILP_GROUND_PROGRAM " map-tiles " + arguments + " > " + out.string() + " 2>&1").c_str()));
    const std::vector<std::uint8_t> said = host::read_file(out);
    return std::string(said.begin(), said.end());
  }
  ReadMap made() {
    std::ostringstream messages;
    EXPECT_FALSE(make_map_tiles(options_, messages).empty());
    return read_map(options_.out);
  }

  fs::path folder_;
  MapTilesOptions options_;
};

/// A raster of `pixel_m` about the longitude and latitude, in the equirectangular projection.
RasterFile about(double longitude, double latitude, std::int32_t side, double pixel_m) {
  RasterFile file{.system = equirectangular, .columns = side, .rows = side};
  const double half = side * pixel_m / 2;
  const double t[6] = {longitude * degree_m - half, pixel_m, 0, latitude * degree_m + half, 0, -pixel_m};
  std::copy(std::begin(t), std::end(t), std::begin(file.t));
  return file;
}

struct Mark {
  double longitude, latitude;
};
const Mark marks[] = {{137.4, -4.6}, {137.405, -4.596}, {137.393, -4.604}, {137.3985, -4.5935}};
constexpr double mark_m = 12;  // sigma of the spots

/// Bright spots of mark_m on grey ground, by the distance on the sphere.
double spots(double longitude, double latitude) {
  double light = 60;
  for (const Mark& mark : marks) {
    const double east = std::remainder(longitude - mark.longitude, 360) * degree_m * std::cos(latitude * radians);
    const double north = (latitude - mark.latitude) * degree_m;
    light += 45 * std::exp(-(east * east + north * north) / (2 * mark_m * mark_m));
  }
  return light;
}

/// Nearly a plane on the ground of this map.
double slope(double longitude, double latitude) {
  return -4400 + 3000 * (longitude - 137.4) - 7000 * (latitude + 4.6);
}

/// Every mark where the projection's formulas have it, to a tenth of a pixel; heights to a step.
void expect_scene(const ReadMap& map) {
  const MapDirectory& directory = *map.directory;
  const double longitude0 = directory.longitude_rad / radians, latitude0 = directory.latitude_rad / radians;
  for (const Mark& mark : marks) {
    const Place truth = transverse_mercator(mars_m, longitude0, latitude0, mark.longitude, mark.latitude);
    for (std::uint32_t layer = 0; layer < directory.layer_count; ++layer) {
      const double pixel_m = directory.layers[layer].pixel_m;
      const auto radius = static_cast<std::int32_t>(4 * mark_m / pixel_m) + 2;
      // The ground about the mark is the floor.
      const Place found = map.centre_of_light(layer, truth, radius, 135);
      EXPECT_NEAR(found.x, truth.x, 0.1 * pixel_m) << mark.longitude << ", layer " << layer;
      EXPECT_NEAR(found.y, truth.y, 0.1 * pixel_m) << mark.longitude << ", layer " << layer;
    }
  }
  std::size_t known = 0;
  for (const auto& tile : map.tiles) {
    const MapLayer& layer = directory.layers[tile->layer];
    for (std::int32_t j = 0; j < map_tile_posts; j += 4) {
      for (std::int32_t i = 0; i < map_tile_posts; i += 4) {
        if (!tile->is_known(i, j)) continue;
        const double x = layer.x0_m + (tile->column * map_tile_side + i * map_post_spacing) * layer.pixel_m;
        const double y = layer.y0_m - (tile->row * map_tile_side + j * map_post_spacing) * layer.pixel_m;
        // The inverse of the projection near its origin (Snyder, 8-6, 8-7).
        const double d = y / mars_m + latitude0 * radians;
        const double latitude = std::asin(std::sin(d) / std::cosh(x / mars_m)) / radians;
        const double longitude = longitude0 + std::atan2(std::sinh(x / mars_m), std::cos(d)) / radians;
        // A post at the border of the rasters is the mean of what is known.
        if (std::fabs(longitude - 137.4) > 0.008 || std::fabs(latitude + 4.6) > 0.008) continue;
        EXPECT_NEAR(tile->height_m(i, j), slope(longitude, latitude), tile->height_step_m) << i << " " << j;
        ++known;
      }
    }
  }
  EXPECT_GT(known, 100U);
}

TEST_F(MapTiles, MarksAndHeightsStandWhereTheProjectionHasThem) {
  const auto in_degrees = [](auto scene) {
    return [scene](double x, double y) { return scene(x / degree_m, y / degree_m); };
  };
  write_raster(options_.image, about(137.4, -4.6, 700, 2), in_degrees(spots));
  write_raster(options_.heights, about(137.4, -4.6, 200, 8), in_degrees(slope));
  const ReadMap map = made();
  EXPECT_EQ(map.directory->body, Body::mars);
  EXPECT_EQ(map.directory->layer_count, 2U);
  EXPECT_EQ(map.directory->layers[1].pixel_m, 20);
  EXPECT_NEAR(map.directory->longitude_rad, 137.4 * radians, 1e-9);
  EXPECT_NEAR(std::cos(map.directory->sun_azimuth_rad), -1, 1e-9) << "the west, from x to y";
  EXPECT_NEAR(map.directory->sun_elevation_rad, 40 * radians, 1e-12);
  expect_scene(map);
}

TEST_F(MapTiles, RastersOfOtherProjectionsAndOfAnotherSphereGiveTheSame) {
  // The image in degrees from 0 to 360, the heights in a stereographic projection that is turned, on a sphere whose
  // radius is that of the place, as HiRISE has it.
  RasterFile image;
  image.system = "+proj=longlat +R=3394839.8 +no_defs";
  image.columns = image.rows = 900;
  const double step = 2 / degree_m;
  const double t[6] = {137.4 - 450 * step, step, 0, -4.6 + 450 * step, 0, -step};
  std::copy(std::begin(t), std::end(t), std::begin(image.t));
  write_raster(options_.image, image, spots);
  RasterFile heights;
  heights.system = "+proj=laea +lat_0=-4.6 +lon_0=137.4 +R=3394839.8 +units=m +no_defs";
  heights.columns = heights.rows = 300;
  const double u[6] = {-1200, 7, 4, 300, 4, -7};
  std::copy(std::begin(u), std::end(u), std::begin(heights.t));
  write_raster(options_.heights, heights, [](double x, double y) {
    // Azimuthal about the middle: to far below a step over a kilometre, arcs on the sphere.
    const double latitude =
        -4.6 + y / 3394839.8 / radians - x * x * std::tan(-4.6 * radians) / (2 * 3394839.8 * 3394839.8) / radians;
    return slope(137.4 + x / (3394839.8 * std::cos(latitude * radians)) / radians, latitude);
  });
  expect_scene(made());
}

TEST_F(MapTiles, OnTheEarthNorthIsAlongTheMeridianOfTheEllipsoid) {
  const double step = 1e-5;
  RasterFile image;
  image.system = "+proj=longlat +datum=WGS84 +no_defs";
  image.columns = 400;
  image.rows = 1200;
  const double t[6] = {11 - 200 * step, step, 0, 48 + 600 * step, 0, -step};
  std::copy(std::begin(t), std::end(t), std::begin(image.t));
  const double mark_latitude = 48 + 400 * step;
  write_raster(options_.image, image, [&](double longitude, double latitude) {
    const double east = (longitude - 11) * 74600, north = (latitude - mark_latitude) * 111200;
    return 60 + 45 * std::exp(-(east * east + north * north) / (2 * 4.0 * 4.0));
  });
  write_raster(options_.heights, image, [](double, double) { return 500.0; });
  options_.pixel_m = 2;
  options_.coarse = 1;
  const ReadMap map = made();
  EXPECT_EQ(map.directory->body, Body::earth);
  // The arc of the meridian: the integral of its radius of curvature.
  const double a = 6378137, e2 = 0.00669437999014;
  double arc_m = 0;
  for (int i = 0; i < 400; ++i) {
    const double s = std::sin((48 + (i + 0.5) * step) * radians);
    arc_m += a * (1 - e2) / std::pow(1 - e2 * s * s, 1.5) * step * radians;
  }
  const Place found = map.centre_of_light(0, {0, arc_m}, 10, 135);
  EXPECT_NEAR(found.x, 0, 0.2);
  EXPECT_NEAR(found.y, arc_m, 0.2);
}

TEST_F(MapTiles, ScaledHeightsMissingValuesAndUnitsAreRead) {
  write_raster(options_.image, about(0, 10, 400, 5), [](double, double) { return 100.0; });
  RasterFile heights = about(0, 10, 100, 20);
  heights.type = RasterFile::Type::i16;
  heights.scale = 0.0005;  // of a kilometre
  heights.offset = -3;
  heights.missing = -32768;
  heights.unit = "km";
  write_raster(options_.heights, heights, [&](double x, double y) {
    const bool hole = x > 200 && y > 10 * degree_m + 200;
    return hole ? std::nan("") : -3 + 0.0005 * 200;
  });
  options_.coarse = 1;
  const ReadMap map = made();
  const MapLayer& layer = map.directory->layers[0];
  std::size_t holes = 0, known = 0;
  for (const auto& tile : map.tiles) {
    for (std::int32_t j = 0; j < map_tile_posts; ++j) {
      for (std::int32_t i = 0; i < map_tile_posts; ++i) {
        const double x = layer.x0_m + (tile->column * 256 + i * 4) * 5.0,
                     y = layer.y0_m - (tile->row * 256 + j * 4) * 5.0;
        if (std::fabs(x) > 950 || std::fabs(y) > 950) continue;
        if (x > 230 && y > 230) {
          EXPECT_FALSE(tile->is_known(i, j)) << x << " " << y;
          ++holes;
        } else if (x < 170 || y < 170) {
          ASSERT_TRUE(tile->is_known(i, j)) << x << " " << y;
          EXPECT_NEAR(tile->height_m(i, j), -2900, tile->height_step_m);
          ++known;
        }
      }
    }
  }
  EXPECT_GT(holes, 500U);
  EXPECT_GT(known, 3000U);
}

TEST_F(MapTiles, TheShadingOfTheHeightsIsDividedOut) {
  // Hills lit from the south-west by Lambert's law; brightness of the ground changes at a line.
  const double azimuth = 225 * radians, elevation = 35 * radians, ambient = 0.25;
  const double sx = std::sin(azimuth) * std::cos(elevation), sy = std::cos(azimuth) * std::cos(elevation);
  const double sz = std::sin(elevation), k = 2 * std::numbers::pi / 400;
  const auto hill = [&](double x, double y) { return 15 * std::sin(k * x) * std::cos(k * (y - 20 * degree_m)); };
  write_raster(options_.heights, about(0, 20, 400, 5), hill);
  const auto lit = [&](double x, double y) {
    const double gy = -15 * k * std::sin(k * x) * std::sin(k * (y - 20 * degree_m));
    // Towards the east a metre on the ground is more than one of the projection, by 1 / cos 20 degrees.
    const double gx = 15 * k * std::cos(k * x) * std::cos(k * (y - 20 * degree_m)) / std::cos(20 * radians);
    const double facing = (sz - gx * sx - gy * sy) / std::sqrt(1 + gx * gx + gy * gy);
    return (x < 0 ? 90 : 110) * (ambient + (1 - ambient) * std::max(facing, 0.0) / sz);
  };
  write_raster(options_.image, about(0, 20, 400, 5), lit);
  options_.sun_azimuth_deg = 225;
  options_.sun_elevation_deg = 35;
  options_.pixel_m = 5;
  options_.coarse = 1;
  options_.image_bits = 4;
  const auto spread = [&](const ReadMap& map) {
    double west[2] = {255, 0}, east[2] = {255, 0};
    const MapLayer& layer = map.directory->layers[0];
    for (double y = -600; y < 600; y += 15) {
      for (double x = 60; x < 600; x += 15) {
        const auto row = static_cast<std::int32_t>((layer.y0_m - y) / 5);
        const double e = map.grey(0, static_cast<std::int32_t>((x - layer.x0_m) / 5), row);
        const double w = map.grey(0, static_cast<std::int32_t>((-x - layer.x0_m) / 5), row);
        east[0] = std::min(east[0], e), east[1] = std::max(east[1], e);
        west[0] = std::min(west[0], w), west[1] = std::max(west[1], w);
      }
    }
    EXPECT_NEAR((east[0] + east[1]) / (west[0] + west[1]), 11.0 / 9, 0.05);
    return std::max(east[1] - east[0], west[1] - west[0]);
  };
  std::ostringstream messages;
  EXPECT_NE(make_map_tiles(options_, messages)[1].find("% as rough as with it"), std::string::npos);
  options_.sun_azimuth_deg = 45;
  EXPECT_NE(make_map_tiles(options_, messages)[1].find("rougher without its shading: check --sun"), std::string::npos);
  options_.sun_azimuth_deg = 225;
  const ReadMap flat = made();
  EXPECT_EQ(flat.directory->light, MapLight::flat);
  EXPECT_LT(spread(flat), 8);
  options_.flat = false;
  const ReadMap as_imaged = made();
  EXPECT_EQ(as_imaged.directory->light, MapLight::as_imaged);
  EXPECT_GT(spread(as_imaged), 45);
}

double texture(double x, double y) {
  double light = 100;
  for (int k = 1; k <= 9; ++k) light += 9 * std::sin(x / (7.0 + 3 * k) + k * k) * std::cos(y / (9.0 + 2 * k) - k);
  return light;
}

TEST_F(MapTiles, TilesHaveFeaturesOfTheLightThatServesInside) {
  write_raster(options_.image, about(0, 0, 600, 4), texture);
  write_raster(options_.heights, about(0, 0, 600, 4), [](double x, double y) { return texture(y, x) / 4; });
  options_.features = 100;
  const auto expect_features = [&](bool of_image) {
    const ReadMap map = made();
    for (std::size_t i = 0; i < map.tiles.size(); ++i) {
      if (map.tiles[i]->layer != 0) continue;
      const MapFeatures& found = of_image ? map.features[i].image : map.features[i].shape;
      EXPECT_GT(found.size(), 40U);
      EXPECT_LE(found.size(), 100U);
      EXPECT_TRUE((of_image ? map.features[i].shape : map.features[i].image).empty());
    }
  };
  expect_features(true);
  options_.flight_sun = sun_of("--flight-sun", 270 + 50, 40, 0.25);
  expect_features(true);
  options_.flight_sun = sun_of("--flight-sun", 270 - 70, 40, 0.25);
  expect_features(false);
  options_.features = 0;
  for (const MapTileFeatures& features : made().features) EXPECT_TRUE(features.image.empty() && features.shape.empty());
}

TEST_F(MapTiles, TheSameGroundGivesTheSameBytesAndAKeySignsThem) {
  write_raster(options_.image, about(0, 0, 300, 5), texture);
  write_raster(options_.heights, about(0, 0, 300, 5), [](double x, double) { return x / 10; });
  const ReadMap first = made();
  const std::vector<std::uint8_t> directory = host::read_file(options_.out / "directory.ilpm");
  // What another map left is removed.
  std::ofstream(options_.out / "tile-1-0099-0099.ilpt") << "old";
  static_cast<void>(made());
  EXPECT_EQ(host::read_file(options_.out / "directory.ilpm"), directory);
  EXPECT_FALSE(fs::exists(options_.out / "tile-1-0099-0099.ilpt"));
  options_.key = folder_ / "keys";
  std::ofstream(options_.key) << "# keys\n7 000102030405060708090a0b0c0d0e0f\n";
  EXPECT_NE(refusal().find("chmod 600"), std::string::npos);
  ::chmod(options_.key.c_str(), 0600);
  std::ostringstream messages;
  make_map_tiles(options_, messages);
  std::vector<std::uint8_t> key(16);
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(read_map(options_.out, key).directory->id, first.directory->id);
  std::ofstream(options_.key) << "7 0001\n";
  EXPECT_NE(refusal().find("16 to 64 octets"), std::string::npos);
}

TEST_F(MapTiles, RastersOfTheWholeBodyAreReadAlsoWhereTheirLongitudesEnd) {
  // Half a degree a pixel around Mars, from 180 degrees west on: in degrees, and in an equirectangular projection.
  const auto height = [](double longitude, double latitude) {
    return 2000 * std::sin(longitude * radians) + 50 * latitude;
  };
  RasterFile globe{.columns = 720, .rows = 360};
  const auto write_globe = [&](const char* system, double unit) {
    globe.system = system;
    const double t[6] = {-180 * unit, 0.5 * unit, 0, 90 * unit, 0, -0.5 * unit};
    std::copy(std::begin(t), std::end(t), std::begin(globe.t));
    write_raster(options_.heights, globe, [&](double x, double y) { return height(x / unit, y / unit); });
  };
  options_.pixel_m = 60;
  options_.coarse = 1;
  options_.features = 0;
  for (const bool in_degrees : {true, false}) {
    write_globe(in_degrees ? "+proj=longlat +R=3396190 +no_defs" : equirectangular, in_degrees ? 1 : degree_m);
    // 179.9 degrees: the image goes on behind 180 in its own coordinates.
    for (const double longitude : {179.9, 90.0, 0.0}) {
      write_raster(options_.image, about(longitude, 0, 500, 60), texture);
      const ReadMap map = made();
      const double middle = map.directory->longitude_rad / radians;
      const MapLayer& layer = map.directory->layers[0];
      EXPECT_EQ(map.tiles.size(), 4U) << longitude;
      std::size_t known = 0;
      for (const auto& tile : map.tiles) {
        for (std::int32_t j = 0; j < map_tile_posts; j += 4) {
          for (std::int32_t i = 0; i < map_tile_posts; i += 4) {
            const std::int32_t column = tile->column * map_tile_side + i * map_post_spacing;
            const std::int32_t row = tile->row * map_tile_side + j * map_post_spacing;
            const double x = layer.x0_m + column * 60, y = layer.y0_m - row * 60;
            if (std::fabs(x) > 14000 || std::fabs(y) > 14000) continue;
            ASSERT_TRUE(tile->is_known(i, j)) << longitude << ": " << x << ", " << y;
            // So near to the equator the plane's x is along it to decimetres.
            EXPECT_NEAR(tile->height_m(i, j), height(middle + x / degree_m, y / degree_m), 1) << x << ", " << y;
            known += map.grey(0, column, row) > 0 ? 1U : 0U;
          }
        }
      }
      EXPECT_GT(known, 800U) << longitude << ": the image is known everywhere";
    }
  }
}

TEST_F(MapTiles, RastersOnNoBodyKeepTheirCoordinates) {
  RasterFile file{.columns = 300, .rows = 300};
  const double t[6] = {1000, 2, 0, 5000, 0, -2};
  std::copy(std::begin(t), std::end(t), std::begin(file.t));
  write_raster(options_.image, file, [](double x, double y) {
    return 60 + 45 * std::exp(-((x - 1250) * (x - 1250) + (y - 4700) * (y - 4700)) / 288);
  });
  write_raster(options_.heights, file, [](double x, double y) { return x - y; });
  options_.area = Extent{1100, 4500, 1500, 4900};
  options_.coarse = 1;
  options_.flat = false;
  const ReadMap map = made();
  EXPECT_EQ(map.directory->body, Body::none);
  EXPECT_EQ(map.directory->layers[0].x0_m, 1100);
  EXPECT_EQ(map.directory->layers[0].y0_m, 4900);
  const Place found = map.centre_of_light(0, {1250, 4700}, 10, 140);
  EXPECT_NEAR(found.x, 1250, 0.5);
  EXPECT_NEAR(found.y, 4700, 0.5);
  EXPECT_NEAR(map.tiles[0]->height_m(10, 10), 1100 + 200 - (4900 - 200), 0.1);
}

/// The worked example of NASA's Mars24: on 2000-01-06 at 00:00 UTC, the sun's longitude is 277.18758 degrees, its
/// declination -24.98 degrees, and the true solar time 23:38:54 at longitude 0, so 10:58:54 at 170 degrees.
TEST_F(MapTiles, ATimeSaysWhereTheSunStood) {
  const auto flat = [](double, double) { return 100.0; };
  write_raster(options_.image, about(170, 0, 200, 5), flat);
  write_raster(options_.heights, about(170, 0, 200, 5), flat);
  options_.sun_days = 4.5;
  const ReadMap map = made();
  EXPECT_NEAR(map.directory->sun_elevation_rad / radians, 60.98, 0.3);
  EXPECT_NEAR(90 - map.directory->sun_azimuth_rad / radians, 150.51, 0.5);
  options_.sun_days = 5;
  EXPECT_NE(refusal().find("--sun: the sun is -"), std::string::npos) << "night: " << refusal();
  options_.sun_days.reset();
  options_.flight_sun_days = 5;
  EXPECT_NE(refusal().find("--flight-sun: the sun is -"), std::string::npos) << refusal();
}

TEST_F(MapTiles, WhatIsWrongIsNamed) {
  const auto flat = [](double, double) { return 100.0; };
  const auto expect_refused = [&](const char* words) {
    EXPECT_NE(refusal().find(words), std::string::npos) << refusal();
  };
  expect_refused("there is no such file");
  write_raster(options_.image, about(10, 0, 200, 5), flat);
  write_raster(options_.heights, about(10, 0, 200, 5), flat);
  EXPECT_EQ(refusal(), "");

  options_.sun_elevation_deg = -3;
  expect_refused("the sun is -3.00 degrees above the horizon");
  options_.sun_elevation_deg = 40;
  options_.sun_azimuth_deg = std::nan("");
  expect_refused("--sun: the sun is 40.0 degrees above the horizon, at an azimuth of –");
  options_.sun_azimuth_deg = 270;
  options_.pixel_m = 2;
  expect_refused("2.50 m or more expected");
  options_.pixel_m = 5;
  options_.body = Body::venus;
  expect_refused("--body is venus, but the rasters are of mars");
  options_.body.reset();
  options_.area = Extent{20, -1, 21, 1};
  expect_refused("--area lies beside the rasters");
  options_.area = Extent{21, -1, 20, 1};
  expect_refused("--area is empty");
  options_.area.reset();
  options_.pixel_m = 5;
  RasterFile large = about(10, 0, 30000, 10);
  large.type = RasterFile::Type::u8;
  large.empty = true;
  write_raster(options_.image, large, flat);
  write_raster(options_.heights, about(10, 0, 60, 5000), flat);
  expect_refused("4096 at most: choose a smaller --area or a larger --pixel");
  write_raster(options_.image, about(10, 0, 200, 5), flat);
  write_raster(options_.heights, about(11, 0, 200, 5), flat);
  expect_refused("image and heights do not overlap");
  RasterFile other = about(10, 0, 200, 5);
  other.system = "+proj=eqc +lat_ts=0 +lon_0=0 +R=1737400 +units=m +no_defs";
  write_raster(options_.heights, other, flat);
  expect_refused("the image shows mars, the heights are of moon");
  other.system = "+proj=eqc +lat_ts=0 +lon_0=0 +R=1188300 +units=m +no_defs";
  write_raster(options_.heights, other, flat);
  expect_refused("a body of 1188300 m radius");
  other = about(10, 0, 200, 5);
  other.unit = "K";
  write_raster(options_.heights, other, flat);
  expect_refused("heights in the unit");
  other = about(10, 0, 200, 5);
  other.t[1] = 0;
  write_raster(options_.heights, other, flat);
  expect_refused("does not say where its pixels are");
  other = about(10, 0, 200, 5);
  other.bands = 3;
  write_raster(options_.heights, other, flat);
  expect_refused("3 bands");
  write_raster(options_.heights, about(10, 0, 200, 5), flat);
  RasterFile nothing = about(10, 0, 200, 5);
  nothing.missing = -1;
  write_raster(options_.image, nothing, [](double, double) { return -1.0; });
  expect_refused("the raster has no data in the area");
  RasterFile polar = about(0, 0, 200, 5);
  polar.system = "+proj=stere +lat_0=90 +lon_0=0 +R=3396190 +units=m +no_defs";
  write_raster(options_.image, polar, flat);
  RasterFile globe;
  globe.system = "+proj=longlat +R=3396190 +no_defs";
  globe.columns = 360;
  globe.rows = 180;
  const double around[6] = {0, 1, 0, 90, 0, -1};
  std::copy(std::begin(around), std::end(around), std::begin(globe.t));
  write_raster(options_.heights, globe, flat);
  expect_refused("heights.tif: its longitudes meet at a pole in the area of the map");
  write_raster(options_.image, about(10, 0, 200, 5), flat);
  write_raster(options_.heights, about(10, 0, 200, 5), flat);
  EXPECT_EQ(refusal(), "");
  std::ofstream(folder_ / "file") << "x";
  options_.out = folder_ / "file" / "map";
  EXPECT_NE(refusal(), "");
}

TEST_F(MapTiles, TheProgramSaysWhatItTakes) {
  const auto run = [&](const std::string& arguments, int& status) { return run_program(arguments, status); };
  int status = -1;
  EXPECT_NE(run("--help", status).find("--place-sigma"), std::string::npos);
  EXPECT_EQ(status, 0);
  EXPECT_NE(run("--sun 10,20 --pixel 1 --out x", status).find("--image and --heights, or --from, expected"),
            std::string::npos);
  EXPECT_EQ(status, 2);
}

/// Results of an earlier flight with two strips: the first has a place, the second none.
void write_results(const fs::path& folder, const std::string& whole_sigma_m) {
  fs::create_directories(folder);
  const auto slope = [](double x, double) { return x / 10; };
  for (const char* end : {".tif", "-strip-3.tif"}) {
    write_raster(folder / ("ortho" + std::string(end)), about(0, 0, 300, 5), texture);
    write_raster(folder / ("height" + std::string(end)), about(0, 0, 300, 5), slope);
  }
  std::ofstream(folder / "report.json") << R"({"strips": [{"id": 1, "grid": {}, "place": {"text": "on Mars", )"
                                        << R"("whole_sigma_m": )" << whole_sigma_m
                                        << R"(}}, {"id": 2, "grid": null}, {"id": 3, "grid": {}, "place": null}]})";
}

TEST_F(MapTiles, AnEarlierFlightIsAMapWithTheErrorOfItsOwnPlace) {
  const fs::path flight = folder_ / "flight", outbox = flight / "outbox", results = flight / "ground";
  fs::create_directories(outbox);
  const auto run = [&](const std::string& arguments, int& status) {
    return run_program("--sun 200,30 --pixel 5 --out " + options_.out.string() + " " + arguments, status);
  };
  int status = -1;
  const std::string none = run("--from " + flight.string(), status);
  EXPECT_EQ(status, 1);
  EXPECT_NE(none.find("ilp-ground " + outbox.string() + " --out " + results.string()), std::string::npos) << none;
  write_results(results, "42.5");
  for (const fs::path& from : {results, flight, outbox}) {
    fs::remove_all(options_.out);
    const std::string said = run("--from " + from.string(), status);
    EXPECT_EQ(status, 0) << said;
    EXPECT_NE(said.find("per km2"), std::string::npos) << said;
    EXPECT_EQ(read_map(options_.out).directory->layers[0].pixel_m, 5);
    EXPECT_EQ(read_map(options_.out).directory->place_sigma_m, 42.5);
  }
  run("--place-sigma 7 --area -0.005,-0.004,0.002,0.003 --from " + flight.string(), status);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(read_map(options_.out).directory->place_sigma_m, 7);
  for (const auto& [arguments, expected] :
       {std::pair{"--strip 3", "it lies on no body"}, {"--strip 2", "there is strip 1, strip 3"}}) {
    const std::string said = run(std::string(arguments) + " --from " + flight.string(), status);
    EXPECT_EQ(status, 1);
    EXPECT_NE(said.find(expected), std::string::npos) << said;
  }
  run("--strip 3 --place-sigma 9 --from " + flight.string(), status);
  EXPECT_EQ(status, 0);
  for (const char* unknown : {"null", "0", "-3", "\"near\"", "1e999"}) {
    write_results(results, unknown);
    const std::string said = run("--from " + flight.string(), status);
    EXPECT_EQ(status, 1) << unknown;
    EXPECT_FALSE(said.find("--place-sigma") == std::string::npos && said.find("no report") == std::string::npos)
        << said;
  }
}

}  // namespace
}  // namespace ilp::maps
