#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <png.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "sim/host/gdal_session.hpp"
#include "sim/host/geo_raster.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/terrain.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::world {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// 61x41 heights of z = 3 + x / 8 - y / 4 every 0.5 m, its first row's first pixel at (-10, 12). All numbers are sums
/// of powers of two.
host::Raster<float> plane() {
  host::Raster<float> heights(61, 41);
  for (int row = 0; row < 41; ++row) {
    for (int column = 0; column < 61; ++column) {
      const float x = -10 + 0.5F * static_cast<float>(column);
      const float y = 12 - 0.5F * static_cast<float>(row);
      heights.at(column, row) = 3 + x / 8 - y / 4;
    }
  }
  return heights;
}

WorldParams imported(const std::filesystem::path& file) {
  WorldParams world{.post_spacing_m = 0.125, .heightmap = file.string()};
  return world;
}

TEST(Heightmap, GeoreferencedPlaneHasThePlanesHeightsExactly) {
  const test::ScratchFolder folder;
  host::write_geotiff(folder / "plane.tif", plane().view(), {-10, 12, 0.5, 0.5});
  WorldParams world = imported(folder / "plane.tif");
  world.map_georeferenced = true;
  const Terrain terrain(world);
  const SurfacePatch patch = terrain.patch({-9, -7, 19, 11});
  for (std::int32_t j = 0; j < patch.rows; ++j) {
    for (std::int32_t i = 0; i < patch.columns; ++i) {
      const double x = (patch.first_i + i) * patch.spacing_m;
      const double y = (patch.first_j + j) * patch.spacing_m;
      ASSERT_EQ(patch.height_m[patch.index(i, j)], static_cast<float>(3 + x / 8 - y / 4)) << x << " " << y;
    }
  }
  EXPECT_EQ(terrain.highest(), 3 + 20.0 / 8 + 8.0 / 4);
}

/// What a file states beside its numbers.
struct Stated {
  double scale = 1, offset = 0;
  std::string unit;
  int epsg = 32632;
  double axis_unit_m = 1;
};

/// The plane with its heights and its coordinates in what is stated.
void write_stated(const std::filesystem::path& path, const Stated& stated, double height_unit_m,
                  const std::function<void(host::Raster<float>&)>& change = {}) {
  host::Raster<float> numbers = plane();
  for (float& value : numbers.samples)
    value = static_cast<float>((double{value} / height_unit_m - stated.offset) / stated.scale);
  if (change) change(numbers);
  const host::GdalSession gdal;
  const host::Dataset file(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), numbers.width, numbers.height, 1, GDT_Float32, nullptr));
  OGRSpatialReference system;
  ASSERT_EQ(system.importFromEPSG(stated.epsg), OGRERR_NONE);
  const double pixel = 0.5 / stated.axis_unit_m;
  double transform[6] = {1000, pixel, 0, 2000, 0, -pixel};
  file->SetGeoTransform(transform);
  file->SetSpatialRef(&system);
  GDALRasterBand& band = *file->GetRasterBand(1);
  if (stated.scale != 1 || stated.offset != 0) {
    band.SetScale(stated.scale);
    band.SetOffset(stated.offset);
  }
  if (!stated.unit.empty()) band.SetUnitType(stated.unit.c_str());
  ASSERT_EQ(band.RasterIO(GF_Write, 0, 0, numbers.width, numbers.height, numbers.samples.data(), numbers.width,
                          numbers.height, GDT_Float32, 0, 0, nullptr),
            CE_None);
}

TEST(Heightmap, ScaleOffsetAndUnitsOfTheFileCount) {
  const test::ScratchFolder folder;
  constexpr double survey_foot_m = 1200.0 / 3937, foot_m = 0.3048;
  const std::tuple<const char*, Stated, double> cases[] = {
      {"metres", {}, 1},
      {"scaled", {0.125, -512, "", 32632, 1}, 1},
      {"kilometres", {1, 0, "km", 32632, 1}, 1000},
      {"feet", {1, 0, "US survey foot", 32632, 1}, survey_foot_m},
      {"scaled feet", {0.1, 32, "ft", 32632, 1}, foot_m},
      {"a plane of feet", {1, 0, "", 2230, survey_foot_m}, survey_foot_m},
      {"metres over a plane of feet", {1, 0, "metre", 2230, survey_foot_m}, 1}};
  for (const auto& [name, stated, height_unit_m] : cases) {
    write_stated(folder / "stated.tif", stated, height_unit_m);
    const Terrain terrain(imported(folder / "stated.tif"));
    // The middle of the map is at the origin, its mean height at 0.
    EXPECT_NEAR(terrain.height(8, 0), 1, 2e-4) << name;
    EXPECT_NEAR(terrain.height(0, 8), -2, 2e-4) << name;
  }
  write_stated(folder / "stated.tif", {1, 0, "fathom", 32632, 1}, 1);
  EXPECT_TRUE(test::says(test::error_of([&] { const Terrain terrain(imported(folder / "stated.tif")); }),
                         "heights in the unit \"fathom\""));
}

TEST(Heightmap, MissingValuesThatNobodyDeclaredAreHoles) {
  const test::ScratchFolder folder;
  for (const float mark : {-9999.0F, -32768.0F, -32767.0F, -3.4e38F}) {
    write_stated(folder / "holes.tif", {}, 1,
                 [mark](host::Raster<float>& numbers) { numbers.at(3, 4) = numbers.at(30, 20) = mark; });
    WorldParams world = imported(folder / "holes.tif");
    EXPECT_TRUE(test::says(test::error_of([&] { const Terrain terrain(world); }), "2 of 2501 pixels have no value"))
        << mark;
    world.fill_holes = true;
    EXPECT_NEAR(Terrain(world).height(8, 0), 1, 1e-2) << mark;
  }
  // With a scale the same number is a height as good as any.
  write_stated(folder / "scaled.tif", {0.001, 0, "", 32632, 1}, 1,
               [](host::Raster<float>& numbers) { numbers.at(3, 4) = -9999; });
  EXPECT_EQ(test::error_of([&] { const Terrain terrain(imported(folder / "scaled.tif")); }), "");
}

// Without coordinates of its own the map's centre is the origin, its mean height the level.
TEST(Heightmap, FloatMapIsCentred) {
  const test::ScratchFolder folder;
  host::write_pfm(folder / "plane.pfm", plane().view());
  WorldParams world = imported(folder / "plane.pfm");
  EXPECT_TRUE(test::says(test::error_of([&] { const Terrain terrain(world); }), "map_spacing_m"));
  world.map_spacing_m = 0.5;
  world.map_x_m = 100;
  const Terrain terrain(world);
  EXPECT_NEAR(terrain.height(100, 0), 0, 1e-5);
  EXPECT_NEAR(terrain.height(108, 0), 1, 1e-5);
  EXPECT_NEAR(terrain.height(100, 4), -1, 1e-5);
}

TEST(Heightmap, GroundBeyondTheMapIsItsMirrorImage) {
  const test::ScratchFolder folder;
  host::write_geotiff(folder / "plane.tif", plane().view(), {-10, 12, 0.5, 0.5});
  WorldParams world = imported(folder / "plane.tif");
  world.map_georeferenced = true;
  const Terrain terrain(world);
  for (const double d : {0.3, 2.0, 9.7, 29.9}) {
    EXPECT_NEAR(terrain.height(20 + d, 1), terrain.height(20 - d, 1), 1e-5);
    EXPECT_NEAR(terrain.height(-10 - d, 1), terrain.height(-10 + d, 1), 1e-5);
  }
  for (const double d : {0.3, 2.0, 9.7}) EXPECT_NEAR(terrain.height(1, 12 + d), terrain.height(1, 12 - d), 1e-5);
  EXPECT_NEAR(terrain.height(3 + 60, 1), terrain.height(3, 1), 1e-5);
}

TEST(Heightmap, GreyLevelsOfEightAndSixteenBitsAreHeights) {
  const test::ScratchFolder folder;
  host::Raster<std::uint8_t> grey(2, 2);
  grey.samples = {0, 100, 0, 100};
  host::write_png(folder / "h8.png", grey.view());
  WorldParams world = imported(folder / "h8.png");
  world.map_spacing_m = 10;
  world.map_height_unit_m = 0.01;
  const Terrain shallow(world);
  EXPECT_NEAR(shallow.height(5, 0) - shallow.height(-5, 0), 1, 1e-6);

  const std::uint16_t deep[] = {1000, 41000, 1000, 41000};
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = 2;
  image.format = PNG_FORMAT_LINEAR_Y;
  ASSERT_NE(png_image_write_to_file(&image, (folder / "h16.png").c_str(), 0, deep, 0, nullptr), 0);
  world.heightmap = (folder / "h16.png").string();
  world.map_height_unit_m = 0.001;
  const Terrain steep(world);
  EXPECT_NEAR(steep.height(5, 0) - steep.height(-5, 0), 40, 1e-4);
}

TEST(Heightmap, HolesAreCountedOrFilled) {
  const test::ScratchFolder folder;
  host::Raster<float> heights = plane();
  for (int row = 10; row < 15; ++row) {
    for (int column = 20; column < 26; ++column) heights.at(column, row) = nan;
  }
  heights.at(0, 0) = std::numeric_limits<float>::infinity();
  host::write_geotiff(folder / "holes.tif", heights.view(), {-10, 12, 0.5, 0.5});
  WorldParams world = imported(folder / "holes.tif");
  world.map_georeferenced = true;
  EXPECT_TRUE(test::says(test::error_of([&] { const Terrain terrain(world); }), "31 of 2501 pixels"));
  world.fill_holes = true;
  const Terrain terrain(world);
  // In the hole's middle, (1.25, 6), the plane has 1.65625; its steepest change over the hole is 0.9.
  EXPECT_NEAR(terrain.height(1.25, 6), 1.65625, 0.2);
  EXPECT_NEAR(terrain.height(5, 0), 3.625, 1e-5);
}

TEST(Heightmap, FilesThatAreNoMapsAreRefused) {
  const test::ScratchFolder folder;
  const auto error = [&](const std::filesystem::path& file) {
    WorldParams world = imported(file);
    world.map_spacing_m = 1;
    return test::error_of([&] { const Terrain terrain(world); });
  };
  EXPECT_TRUE(test::says(error(folder.write("notes.txt", "3 4 5\n")), "neither GeoTIFF nor"));
  EXPECT_TRUE(test::says(error(folder / "absent.tif"), "absent.tif"));
  EXPECT_TRUE(test::says(error(folder.path()), "a folder"));
  const host::Raster<host::Rgb> colour(4, 4);
  host::write_png(folder / "colour.png", colour.view());
  EXPECT_TRUE(test::says(error(folder / "colour.png"), "colour"));
  host::write_pfm(folder / "one.pfm", host::Raster<float>(1, 9).view());
  EXPECT_TRUE(test::says(error(folder / "one.pfm"), "2x2"));
  host::write_pfm(folder / "none.pfm", host::Raster<float>(9, 9, nan).view());
  EXPECT_TRUE(test::says(error(folder / "none.pfm"), "81 of 81"));
}

TEST(Heightmap, AFileWhoseHeightsOverflowIsNamed) {
  const test::ScratchFolder folder;
  host::write_pfm(folder / "huge.pfm", host::Raster<float>(9, 9, 3e38F).view());
  WorldParams world = imported(folder / "huge.pfm");
  world.map_spacing_m = 1;
  world.map_height_unit_m = 10;
  EXPECT_TRUE(test::says(test::error_of<std::invalid_argument>([&] { const Terrain terrain(world); }), "huge.pfm"));
}

// A picture without scale lies upon the heights; its mean becomes 1 and its halves keep their ratio.
TEST(Heightmap, BrightnessComesFromTheAlbedoMap) {
  const test::ScratchFolder folder;
  host::write_pfm(folder / "level.pfm", host::Raster<float>(41, 41, 7.0F).view());
  host::Raster<std::uint8_t> grey(200, 200, 50);
  for (int y = 0; y < 200; ++y) {
    for (int x = 100; x < 200; ++x) grey.at(x, y) = 150;
  }
  host::write_png(folder / "ortho.png", grey.view());
  WorldParams world = imported(folder / "level.pfm");
  world.map_spacing_m = 0.5;
  world.albedo_map = (folder / "ortho.png").string();
  const SurfacePatch patch = Terrain(world).patch({-9, -9, 9, 9});
  for (std::int32_t i = 0; i < patch.columns; ++i) {
    const double x = (patch.first_i + i) * patch.spacing_m;
    const float light = patch.radiance[patch.index(i, 40)];
    if (x < -0.2) {
      ASSERT_NEAR(light, 0.5, 1e-5) << x;
    }
    if (x > 0.2) {
      ASSERT_NEAR(light, 1.5, 1e-5) << x;
    }
  }
}

TEST(Heightmap, LandformsMayBePutUponImportedGround) {
  const test::ScratchFolder folder;
  host::write_pfm(folder / "level.pfm", host::Raster<float>(41, 41, 7.0F).view());
  WorldParams world = imported(folder / "level.pfm");
  world.map_spacing_m = 5;
  EXPECT_TRUE(Terrain(world).features({0, 0, 50, 50}).empty());
  world.heightmap_landforms = true;
  const Terrain terrain(world);
  EXPECT_FALSE(terrain.features({0, 0, 50, 50}).empty());
  double lowest = 0;
  for (const float height : terrain.patch({0, 0, 50, 50}).height_m) lowest = std::min<double>(lowest, height);
  EXPECT_LT(lowest, -0.3);
  EXPECT_GE(lowest, terrain.lowest());
}

}  // namespace
}  // namespace ilp::world
