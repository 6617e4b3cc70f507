// The map in tiles is the map of the ground.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/map/strip_map.hpp"
#include "sim/ground/map/surface_tile.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::map {
namespace {

/// Six tiles or more over a plane.
class StripMapTest : public testing::Test {
 protected:
  StripMapTest() {
    test::SyntheticFlight flight = test::make_flight(false);
    flight.camera = {320, 240, 300, 300, 159.5, 119.5, 0, 0, 0, 0};
    test::write_outbox(flight, folder_.path());
    intake::Outbox outbox = intake::read_outbox(folder_.path());
    flight_ = intake::index_flight(outbox);
    strip_ = flight_.strips.at(1);
    PixelRays rays;
    for (const std::int64_t id : strip_.keyframes) {
      const intake::Keyframe& keyframe = flight_.keyframes.at(id);
      const KeyframeQuickLook quick_look = quick_look_at(keyframe, intake::decode_products(keyframe).rasters, 1, rays);
      views_[id] = {keyframe_digest(keyframe), quick_look.ground_step, quick_look.bounds};
    }
  }

  std::optional<StripMap> merge(intake::TileCache& cache, MapParams params = {}) {
    return merge_strip(flight_, strip_, views_, cache, params, {});
  }

  test::TemporaryFolder folder_;
  intake::Flight flight_;
  intake::Strip strip_;
  KeyframeViews views_;
};

TEST_F(StripMapTest, EveryCellLiesOnTheGroundAndNoneIsMissingWhereTilesMeet) {
  intake::MemoryTileCache cache;
  const auto map = merge(cache);
  ASSERT_TRUE(map);
  ASSERT_GE(map->mosaic.tile_columns * map->mosaic.tile_rows, 6);
  const GroundGrid grid = overview(map->mosaic, {});
  ASSERT_EQ(grid.height.width, map->mosaic.geometry.columns);
  std::size_t holes = 0;
  for (std::int32_t j = 1; j + 1 < grid.height.height; ++j) {
    for (std::int32_t i = 1; i + 1 < grid.height.width; ++i) {
      const float z = grid.height.at(i, j);
      const double x = grid.x0 + i * grid.cell, y = grid.y0 - j * grid.cell;
      if (std::isfinite(z)) {
        ASSERT_NEAR(z, test::plane_height(x, y), 0.02) << i << " " << j;
      } else {
        // Four covered neighbours: not a notch of the border.
        bool inside = true;
        for (const int k : {-1, 1}) {
          inside = inside && std::isfinite(grid.height.at(i + k, j)) && std::isfinite(grid.height.at(i, j + k));
        }
        holes += inside ? 1U : 0U;
      }
    }
  }
  EXPECT_EQ(holes, 0U);
  const double cells = static_cast<double>(map->statistics.measured_cells);
  EXPECT_NEAR(map->statistics.covered_area, cells * grid.cell * grid.cell, 1e-9);
}

/// A level rectangle of the world, two triangles for each cell.
std::shared_ptr<const SurfaceMesh> level(int left, int right, int top, int bottom, std::uint8_t grey = 100) {
  SurfaceMesh mesh;
  const auto columns = static_cast<std::uint32_t>(right - left + 1);
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      mesh.vertices.push_back({static_cast<float>(column), static_cast<float>(-row), 2, grey, 0});
    }
  }
  for (std::uint32_t v = 0; v + columns < mesh.vertices.size(); ++v) {
    if (v % columns + 1 == columns) continue;
    mesh.faces.push_back({v, v + columns, v + 1});
    mesh.faces.push_back({v + 1, v + columns, v + columns + 1});
  }
  return std::make_shared<const SurfaceMesh>(std::move(mesh));
}

TEST(SurfaceTile, ASeamAlongTheBorderOfTwoTilesIsClosed) {
  // The last column of the tile is empty between two pieces.
  const SurfaceTile tile =
      paint_tile({0, 0}, 1, {{1, level(200, tile_side_cells - 2, 10, 40)}, {2, level(tile_side_cells, 300, 10, 40)}});
  const MapTile finished = finish_tile({0, 0}, tile.cells, {Balance{}, Balance{}}, 1);
  for (int row = 10; row <= 40; ++row) {
    ASSERT_EQ(finished.height.at(tile_side_cells - 1, row), 2) << row;
    ASSERT_EQ(finished.count.at(tile_side_cells - 1, row), 0) << row;
  }
  EXPECT_EQ(tile.summary.shown[0].cells + tile.summary.shown[1].cells, (256 - 200) * 31U);
}

TEST(SurfaceTile, WherePatchesOverlapTheImageIsThatOfOneAndBothSayHowTheyDiffer) {
  // The second one is brighter and covers the first one too.
  const SurfaceTile tile = paint_tile({0, 0}, 1, {{7, level(20, 119, 10, 60, 40)}, {9, level(20, 200, 10, 60, 90)}});
  for (std::int32_t x = 25; x < 195; ++x) {
    ASSERT_EQ(tile.cells.ortho.at(tile_margin_cells + x, tile_margin_cells + 50), x < 120 ? 40 : 90) << x;
  }
  const SeamGreys& greys = tile.summary.seams.at({7, 9});
  ASSERT_EQ(greys.first.entries().size(), 1U);
  ASSERT_EQ(greys.second.entries().size(), 1U);
  EXPECT_EQ(greys.first.entries()[0].first, 40);
  EXPECT_EQ(greys.second.entries()[0].first, 90);
  EXPECT_GT(greys.first.count(), tile.summary.seam_cells - 1) << "every cell of the overlap counts";
}

TEST_F(StripMapTest, MemoryAndThreadsDoNotShowInTheResult) {
  intake::MemoryTileCache cache, other;
  const auto map = merge(cache);
  MapParams small{.chunk_bytes = 1, .threads = 1};
  const auto again = merge(other, small);
  ASSERT_TRUE(map && again);
  const GroundGrid a = overview(map->mosaic, {}), b = overview(again->mosaic, {});
  EXPECT_EQ(a.ortho.samples, b.ortho.samples);
  EXPECT_EQ(a.source.samples, b.source.samples);
  ASSERT_EQ(a.height.samples.size(), b.height.samples.size());
  for (std::size_t i = 0; i < a.height.samples.size(); ++i) {
    ASSERT_TRUE(a.height.samples[i] == b.height.samples[i] || std::isnan(a.height.samples[i]));
  }
}

TEST_F(StripMapTest, AChangedKeyframePaintsOnlyTheTilesUnderIt) {
  intake::MemoryTileCache cache;
  const auto first = merge(cache);
  ASSERT_TRUE(first);
  EXPECT_EQ(merge(cache)->statistics.painted, 0U);
  views_.at(5).digest += 1;
  const auto second = merge(cache);
  EXPECT_GT(second->statistics.painted, 0U);
  EXPECT_LT(second->statistics.painted, first->statistics.painted);
}

TEST_F(StripMapTest, TheOverviewOfALargeMapHasItsMeans) {
  intake::MemoryTileCache cache;
  const auto map = merge(cache);
  GridParams coarse{.max_side = 100};
  const GroundGrid grid = overview(map->mosaic, coarse);
  EXPECT_LE(std::max(grid.height.width, grid.height.height), 100);
  EXPECT_GT(grid.cell, map->mosaic.geometry.cell);
  for (std::int32_t j = 0; j < grid.height.height; ++j) {
    for (std::int32_t i = 0; i < grid.height.width; ++i) {
      if (!std::isfinite(grid.height.at(i, j))) continue;
      // At the border of the map a block is only partly covered.
      ASSERT_NEAR(grid.height.at(i, j), test::plane_height(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell),
                  0.02 + 0.1 * grid.cell);
    }
  }
}

TEST_F(StripMapTest, AKeyframeFarFromAllOthersMakesTheCellsCoarserAndNotTheMemoryEndless) {
  intake::MemoryTileCache cache;
  views_.at(5).bounds = {1e8, 1e8 + 1, 1e8, 1e8 + 1};
  const auto map = merge(cache);
  ASSERT_TRUE(map);
  EXPECT_GT(map->mosaic.geometry.cell, 100);
}

TEST_F(StripMapTest, ADamagedTileOfTheCacheIsPaintedAnew) {
  class Damaging : public intake::MemoryTileCache {
   public:
    void put(const intake::TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
             std::vector<std::uint8_t> cells) override {
      if (damages) summary.resize(summary.size() / 2);
      intake::MemoryTileCache::put(key, digest, std::move(summary), std::move(cells));
    }
    bool damages = true;
  } cache;
  const auto first = merge(cache);
  cache.damages = false;
  EXPECT_EQ(merge(cache)->statistics.painted, first->statistics.painted);
  EXPECT_EQ(merge(cache)->statistics.painted, 0U);
}

}  // namespace
}  // namespace ilp::map
