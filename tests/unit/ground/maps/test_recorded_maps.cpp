// Maps of an image of HiRISE and of a terrain model of the Moon, where these data are beside the project.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <sstream>

#include "sim/host/image_io.hpp"
#include "tests/support/read_image.hpp"
#include "tests/unit/ground/maps/scene.hpp"

namespace ilp::maps {
namespace {
namespace fs = std::filesystem;

class RecordedMaps : public ::testing::Test {
 protected:
  RecordedMaps() : folder_(fs::temp_directory_path() / ("ilp-recorded-maps-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    options_.image = folder_ / "image.tif";
    options_.heights = folder_ / "heights.tif";
    options_.sun_azimuth_deg = 300;
    options_.sun_elevation_deg = 35;
    options_.coarse = 1;
    options_.flat = false;
    options_.out = folder_ / "map";
  }
  ~RecordedMaps() override { fs::remove_all(folder_); }

  /// Pixel (column, row) of the raster at a place of its own plane, whose north-western corner is (0, 0).
  void write(const fs::path& path, const host::Raster<std::uint8_t>& picture, double pixel_m, double scale) const {
    test::RasterFile file{.columns = picture.width, .rows = picture.height};
    file.t[1] = pixel_m;
    file.t[5] = -pixel_m;
    file.missing = -1;
    test::write_raster(path, file, [&](double x, double y) {
      const std::uint8_t value =
          picture.at(static_cast<std::int32_t>(x / pixel_m), static_cast<std::int32_t>(-y / pixel_m));
      return scale * value;
    });
  }
  test::ReadMap made() {
    std::ostringstream messages;
    EXPECT_FALSE(make_map_tiles(options_, messages).empty());
    return test::read_map(options_.out);
  }

  fs::path folder_;
  MapTilesOptions options_;
};

TEST_F(RecordedMaps, AnImageOfMarsKeepsItsTextureInHalfABitPerPixel) {
  const fs::path file = fs::path(test::data_root) / "mars_hirise_pair_a/before.png";
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  const host::Raster<std::uint8_t> picture = host::read_gray(file);
  constexpr double pixel_m = 0.2526;
  write(options_.image, picture, pixel_m, 1);
  write(options_.heights, host::Raster<std::uint8_t>(picture.width, picture.height, 7), pixel_m, 1);
  options_.pixel_m = 2 * pixel_m;
  const test::ReadMap map = made();
  double mean = 0;
  for (const std::uint8_t grey : picture.samples) mean += grey / static_cast<double>(picture.samples.size());
  // A cell of the map is the mean of four pixels.
  double squares = 0, all = 0, truth_mean = 0, truth_squares = 0;
  std::size_t count = 0;
  for (std::int32_t row = 2; row < 250; ++row) {
    for (std::int32_t column = 2; column < 250; ++column, ++count) {
      const double sum = picture.at(2 * column, 2 * row) + picture.at(2 * column + 1, 2 * row) +
                         picture.at(2 * column, 2 * row + 1) + picture.at(2 * column + 1, 2 * row + 1);
      const double truth = sum / 4 / mean * 128;
      const double error = map.grey(0, column, row) - truth;
      squares += error * error;
      all += error;
      truth_mean += truth;
      truth_squares += truth * truth;
    }
  }
  const double n = static_cast<double>(count), variance = truth_squares / n - truth_mean / n * (truth_mean / n);
  EXPECT_LT(std::fabs(all / n), 2);
  EXPECT_LT(squares / n, 0.1 * variance) << "of the texture, a tenth of the power may be lost";
  EXPECT_LE(map.directory->tiles[0].bytes, 256 * 256 / 16 + 256 * 38 + 300);
}

TEST_F(RecordedMaps, PostsOfTheMoonAreMeansOfItsModelToHalfAStep) {
  const fs::path file = fs::path(test::data_root) / "moon_apollo15_dtm/height_8bit.png";
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  const host::Raster<std::uint8_t> picture = host::read_gray(file);
  constexpr double post_m = 2, metres = 49.0 / 255;
  write(options_.heights, picture, post_m, metres);
  write(options_.image, host::Raster<std::uint8_t>(picture.width, picture.height, 100), post_m, 1);
  options_.pixel_m = post_m;
  const test::ReadMap map = made();
  ASSERT_GE(map.tiles.size(), 1U);
  const MapTile& tile = *map.tiles[0];
  for (std::int32_t j = 1; j < map_tile_posts - 1; ++j) {
    for (std::int32_t i = 1; i < map_tile_posts - 1; ++i) {
      // A square of 4 x 4 pixels about the corner (4 i, 4 j).
      double sum = 0;
      for (std::int32_t b = -2; b < 2; ++b) {
        for (std::int32_t a = -2; a < 2; ++a) sum += picture.at(4 * i + a, 4 * j + b);
      }
      ASSERT_TRUE(tile.is_known(i, j));
      ASSERT_NEAR(tile.height_m(i, j), metres * sum / 16, tile.height_step_m / 2 + 0.01) << i << " " << j;
    }
  }
  EXPECT_LT(map.directory->tiles[0].bytes, 6000);
}

}  // namespace
}  // namespace ilp::maps
