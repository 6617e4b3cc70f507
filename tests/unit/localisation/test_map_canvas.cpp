// A window of the map, painted tile by tile, against formulas.
#include "fsw/localisation/map_canvas.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

constexpr double pixel = 2;

double grey_at(double x, double y) {
  return 120 + 0.1 * x - 0.07 * y;
}
double height_of(double x, double y) {
  return 0.02 * x + 0.01 * y - 3;
}

class MapCanvasTest : public testing::Test {
 protected:
  MapCanvasTest() { layer = {pixel, -300, 400, 3, 2}; }

  [[nodiscard]] double x0(std::int32_t column) const { return layer.x0_m + pixel * map_tile_side * column; }
  [[nodiscard]] double y0(std::int32_t row) const { return layer.y0_m - pixel * map_tile_side * row; }
  const MapTile& tile(std::int32_t row, std::int32_t column) {
    tile_->row = static_cast<std::uint16_t>(row);
    tile_->column = static_cast<std::uint16_t>(column);
    tile_->height_step_m = 0.001;
    for (std::int32_t r = 0; r < map_tile_side; ++r) {
      for (std::int32_t c = 0; c < map_tile_side; ++c) {
        const double grey = grey_at(x0(column) + (c + 0.5) * pixel, y0(row) - (r + 0.5) * pixel);
        tile_->image[static_cast<std::size_t>(r * map_tile_side + c)] = static_cast<std::uint8_t>(grey + 0.5);
      }
    }
    for (std::int32_t j = 0; j < map_tile_posts; ++j) {
      for (std::int32_t i = 0; i < map_tile_posts; ++i) {
        const double height = height_of(x0(column) + 4 * i * pixel, y0(row) - 4 * j * pixel);
        tile_->posts[static_cast<std::size_t>(j * map_tile_posts + i)] =
            static_cast<std::int16_t>(std::floor(height / 0.001 + 0.5));
      }
    }
    return *tile_;
  }
  static MapPlan plan_of(double pixel_m, double x_m, double y_m, std::int32_t side) {
    MapPlan plan;
    plan.pixel_m = pixel_m;
    plan.first_column = static_cast<std::int64_t>(std::floor(x_m / pixel_m));
    plan.first_row = static_cast<std::int64_t>(std::floor(-y_m / pixel_m));
    plan.width = plan.height = side;
    return plan;
  }
  void paint_all(const MapPlan& plan) {
    begin_canvas(plan, *canvas);
    const MapTileRange range = tiles_under(plan, layer);
    for (std::int32_t row = range.first_row; row <= range.last_row; ++row) {
      for (std::int32_t column = range.first_column; column <= range.last_column; ++column)
        EXPECT_TRUE(paint_tile(tile(row, column), layer, plan, *canvas).ok());
    }
    finish_canvas(plan, layer, *canvas);
  }

  MapLayer layer;
  std::unique_ptr<MapCanvas> canvas = std::make_unique<MapCanvas>();

 private:
  std::unique_ptr<MapTile> tile_ = std::make_unique<MapTile>();
};

TEST_F(MapCanvasTest, CellsAreMeansOfTheirAreaAcrossTiles) {
  // Across the corner of four tiles.
  for (const double pixel_m : {2.0, 2.7, 5.0, 13.1}) {
    const auto side = static_cast<std::int32_t>(300 / pixel_m);
    const MapPlan plan = plan_of(pixel_m, x0(1) - 150, y0(1) + 150, side);
    EXPECT_EQ(tiles_under(plan, layer).count(), 4);
    paint_all(plan);
    for (std::int32_t row = 0; row < side; ++row) {
      for (std::int32_t column = 0; column < side; ++column) {
        const double x = plan.x0_m() + (column + 0.5) * pixel_m, y = plan.y0_m() - (row + 0.5) * pixel_m;
        const auto cell = static_cast<std::size_t>(row * side + column);
        ASSERT_NEAR(canvas->image[cell], grey_at(x, y), 1.1) << pixel_m << " " << column << " " << row;
        ASSERT_EQ(canvas->known[cell], 1);
        ASSERT_NEAR(canvas->height_m[cell], height_of(x, y), 0.002);
      }
    }
  }
}

TEST_F(MapCanvasTest, WhatTheMapDoesNotHaveIsUnknown) {
  const MapPlan plan = plan_of(4, layer.x0_m - 200, layer.y0_m + 100, 100);
  paint_all(plan);
  for (std::int32_t row = 0; row < 100; ++row) {
    for (std::int32_t column = 0; column < 100; ++column) {
      const bool inside = plan.x0_m() + (column + 0.5) * 4 > layer.x0_m && plan.y0_m() - (row + 0.5) * 4 < layer.y0_m;
      const auto cell = static_cast<std::size_t>(row * 100 + column);
      EXPECT_EQ(canvas->image[cell] != 0, inside);
      EXPECT_EQ(canvas->known[cell] != 0, inside);
    }
  }
  const MapPlan away = plan_of(4, 1e9, 0, 100);
  EXPECT_EQ(tiles_under(away, layer).count(), 0);
}

TEST_F(MapCanvasTest, PixelsThatSumsCannotHoldAreRefused) {
  const MapTile& one = tile(0, 0);
  EXPECT_STATUS(paint_tile(one, layer, plan_of(1.9, -300, 400, 10), *canvas), invalid_argument);
  EXPECT_STATUS(paint_tile(one, layer, plan_of(61, -300, 400, 2), *canvas), invalid_argument);
}

TEST_F(MapCanvasTest, TheHeightOfAPlaceIsThatOfItsPosts) {
  const MapTile& one = tile(1, 2);
  double height = 0;
  EXPECT_TRUE(tile_height(one, layer, x0(2) + 101.3, y0(1) - 77.7, height));
  EXPECT_NEAR(height, height_of(x0(2) + 101.3, y0(1) - 77.7), 0.002);
  EXPECT_FALSE(tile_height(one, layer, x0(2) - 1, y0(1) - 77.7, height));
}

}  // namespace
}  // namespace ilp
