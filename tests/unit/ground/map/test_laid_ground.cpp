// Ground without a measured height is laid on interpolated heights: for pictures, never among the heights.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/ground/map/strip_map.hpp"
#include "sim/ground/map/surface_tile.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::map {
namespace {

constexpr std::int32_t width = 320, height = 240;
constexpr double cell = 1.0 / 30;

struct Box {
  std::int32_t left = 0, right = 0, top = 0, bottom = 0;
  [[nodiscard]] bool has(std::int32_t x, std::int32_t y) const {
    return x >= left && x <= right && y >= top && y <= bottom;
  }
};
constexpr Box seen{20, 299, 20, 219}, hole{120, 159, 100, 129};
// Wider than what is laid, both ways; and one that the end of what was seen leaves open.
constexpr Box wide{180, 280, 60, 200}, open{60, 90, 20, 50};

/// Grey of a pixel of the image: a ramp, so that it names the place.
std::uint8_t grey_at(std::int32_t x, std::int32_t y) {
  return static_cast<std::uint8_t>(60 + x / 4 + y / 3);
}

/// One level view, 10 above the test's plane at the origin, whose image shows more than what was measured.
class LaidGroundTest : public testing::Test {
 protected:
  LaidGroundTest() {
    keyframe_.id = 7;
    keyframe_.camera = {width, height, 300, 300, 159.5, 119.5, 0, 0, 0, 0};
    keyframe_.pose.emplace();
    keyframe_.pose->state = PoseState::final;
    // Looks down: y of the image to the south.
    keyframe_.pose->q_cam_from_world[0] = 0;
    keyframe_.pose->q_cam_from_world[1] = 1;
    keyframe_.pose->centre[2] = 11;
    keyframe_.image = host::Raster<std::uint8_t>(width, height);
    keyframe_.inverse_depth = host::Raster<float>(width, height);
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        keyframe_.image.at(x, y) = grey_at(x, y);
        if (seen.has(x, y) && !hole.has(x, y) && !wide.has(x, y) && !open.has(x, y))
          keyframe_.inverse_depth.at(x, y) = static_cast<float>(1 / depth_at(x, y));
      }
    }
  }

  /// Of z = 0.06 x - 0.04 y + 1 along the pixel's ray.
  static double depth_at(std::int32_t x, std::int32_t y) {
    const double u = (x - 159.5) / 300, v = (y - 119.5) / 300;
    return 10 / (1 + 0.06 * u + 0.04 * v);
  }

  [[nodiscard]] MapTile painted(std::int32_t column, std::int32_t row) {
    PixelRays rays;
    const TilePatch patch{7, std::make_shared<const SurfaceMesh>(keyframe_surface(keyframe_, keyframe_, {}, rays)),
                          std::make_shared<const SurfaceMesh>(laid_surface(keyframe_, keyframe_, rays))};
    return finish_tile({column, row}, paint_tile({column, row}, cell, {patch}).cells, {Balance{}}, cell);
  }

  intake::Keyframe keyframe_;
};

TEST_F(LaidGroundTest, LiesOnThePlaneAboutAHoleWithTheGreyOfTheImage) {
  std::size_t measured = 0, laid = 0;
  for (const auto& [column, row] : {std::pair{-1, -1}, {0, -1}, {-1, 0}, {0, 0}}) {
    const MapTile tile = painted(column, row);
    for (std::int32_t j = 0; j < tile_side_cells; ++j) {
      for (std::int32_t i = 0; i < tile_side_cells; ++i) {
        const double x = (column * tile_side_cells + i) * cell, y = -(row * tile_side_cells + j) * cell;
        const double z = test::plane_height(x, y);
        const bool has_height = std::isfinite(tile.height.at(i, j));
        measured += has_height ? 1U : 0U;
        if (tile.laid.grey.at(i, j) == 0) {
          ASSERT_FALSE(std::isfinite(tile.laid.height.at(i, j)));
          continue;
        }
        ++laid;
        ASSERT_FALSE(has_height) << "the heights keep their holes";
        ASSERT_EQ(tile.count.at(i, j), 0);
        ASSERT_NEAR(tile.laid.height.at(i, j), z, 1e-3);
        const double u = 300 * x / (11 - z) + 159.5, v = -300 * y / (11 - z) + 119.5;
        ASSERT_NEAR(tile.laid.grey.at(i, j), 60 + u / 4 + v / 3, 2);
        // Nothing outside of what was seen, and nothing in the other holes.
        ASSERT_TRUE(u > hole.left - 2 && u < hole.right + 2 && v > hole.top - 2 && v < hole.bottom + 2)
            << u << " " << v;
      }
    }
  }
  EXPECT_GT(measured, 20000U);
  // A cell is a thirtieth, a pixel on the ground too.
  EXPECT_NEAR(static_cast<double>(laid), 40 * 30, 150);
}

TEST_F(LaidGroundTest, NothingIsLaidWithoutAnImageOrWithoutAHole) {
  PixelRays rays;
  intake::KeyframeRasters rasters = keyframe_;
  rasters.image = {};
  EXPECT_TRUE(laid_surface(keyframe_, rasters, rays).faces.empty());
  rasters = keyframe_;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) rasters.inverse_depth.at(x, y) = static_cast<float>(1 / depth_at(x, y));
  }
  EXPECT_TRUE(laid_surface(keyframe_, rasters, rays).faces.empty());
}

TEST_F(LaidGroundTest, IsBalancedAsItsKeyframeIsAndKeptInTheBytesOfATile) {
  PixelRays rays;
  const TilePatch patch{7, std::make_shared<const SurfaceMesh>(keyframe_surface(keyframe_, keyframe_, {}, rays)),
                        std::make_shared<const SurfaceMesh>(laid_surface(keyframe_, keyframe_, rays))};
  const SurfaceTile tile = paint_tile({-1, -1}, cell, {patch});
  const auto read = cells_from(bytes_of(tile.cells), painted_side_cells);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->laid.grey.samples, tile.cells.laid.grey.samples);
  EXPECT_EQ(read->laid.source.samples, tile.cells.laid.source.samples);
  const MapTile plain = finish_tile({-1, -1}, tile.cells, {Balance{}}, cell),
                darker = finish_tile({-1, -1}, tile.cells, {{1, -30}}, cell);
  std::size_t cells = 0;
  for (std::size_t i = 0; i < plain.laid.grey.samples.size(); ++i) {
    if (plain.laid.grey.samples[i] == 0) continue;
    ++cells;
    ASSERT_EQ(plain.laid.grey.samples[i] - darker.laid.grey.samples[i], 30);
  }
  EXPECT_GT(cells, 100U);
}

}  // namespace
}  // namespace ilp::map
