// Two pieces of a map that lie side by side become one surface of one brightness.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/ground/map/grid_surface.hpp"
#include "sim/ground/map/seams.hpp"

namespace ilp::map {
namespace {

constexpr std::int32_t width = 80;
constexpr std::int32_t height = 60;
constexpr std::int32_t gap = 40;  ///< first empty column

/// Level ground that rises to the east; the second keyframe was exposed half as long.
GroundGrid two_patches(std::int32_t gap_columns) {
  GroundGrid grid;
  grid.cell = 0.5;
  grid.height = host::Raster<float>(width, height, std::numeric_limits<float>::quiet_NaN());
  grid.ortho = host::Raster<std::uint8_t>(width, height);
  grid.count = host::Raster<std::uint16_t>(width, height);
  grid.source = host::Raster<std::uint16_t>(width, height);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      if (x >= gap && x < gap + gap_columns) continue;
      grid.height.at(x, y) = 0.1F * static_cast<float>(x);
      const int texture = (x * 7 + y * 13) % 11;
      grid.ortho.at(x, y) = static_cast<std::uint8_t>(x < gap ? 120 + 2 * texture : 60 + texture);
      grid.count.at(x, y) = 1;
      grid.source.at(x, y) = x < gap ? 1 : 2;
    }
  }
  return grid;
}

TEST(Seams, TwoPiecesAreOneSurfaceOnceTheGapIsClosed) {
  constexpr std::size_t whole = 2 * (width - 1) * (height - 1);
  GroundGrid grid = two_patches(2);
  EXPECT_EQ(grid_surface(grid, 1, {}).faces.size(), whole - 2 * 3 * (height - 1));
  close_seams(grid);
  const SurfaceMesh surface = grid_surface(grid, 1, {});
  EXPECT_EQ(surface.vertices.size(), static_cast<std::size_t>(width) * height);
  EXPECT_EQ(surface.faces.size(), whole);
  for (const SurfaceVertex& v : surface.vertices) ASSERT_NEAR(v.z, 0.1 * v.x / grid.cell, 1e-4);
}

TEST(Seams, AWallIsNotPartOfTheSurfaceAndTheStrideBoundsTheVertices) {
  GroundGrid grid = two_patches(0);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = gap; x < width; ++x) grid.height.at(x, y) += 3;  // over half a unit: 6 times as high as far
  }
  EXPECT_EQ(grid_surface(grid, 1, {}).faces.size(), 2U * (width - 2) * (height - 1));
  for (const std::size_t most : {1U, 50U, 1000U, 100000U}) {
    const std::int32_t stride = stride_for(grid, most);
    EXPECT_LE(grid_surface(grid, stride, {}).vertices.size(), most);
    if (stride == 1) continue;
    EXPECT_GT(grid_surface(grid, stride - 1, {}).vertices.size(), most);
  }
}

TEST(Seams, ANarrowGapBetweenPiecesIsClosedOnTheLineBetweenThem) {
  for (const std::int32_t columns : {1, 2}) {
    GroundGrid grid = two_patches(columns);
    close_seams(grid);
    for (std::int32_t x = gap; x < gap + columns; ++x) {
      EXPECT_NEAR(grid.height.at(x, 30), 0.1 * x, 1e-5);
      EXPECT_GT(grid.ortho.at(x, 30), 50);
      EXPECT_EQ(grid.count.at(x, 30), 0) << "nothing was measured here, and the count says so";
    }
  }
}

TEST(Seams, WideGapsHolesInsideAPieceAndCliffsStay) {
  GroundGrid wide = two_patches(5);
  close_seams(wide);
  EXPECT_FALSE(std::isfinite(wide.height.at(gap + 2, 30)));

  GroundGrid hole = two_patches(1);
  hole.source.at(20, 20) = 0;
  hole.height.at(20, 20) = std::numeric_limits<float>::quiet_NaN();
  close_seams(hole);
  EXPECT_FALSE(std::isfinite(hole.height.at(20, 20)));

  GroundGrid cliff = two_patches(1);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = gap + 1; x < width; ++x) cliff.height.at(x, y) += 30;
  }
  close_seams(cliff);
  EXPECT_FALSE(std::isfinite(cliff.height.at(gap, 30)));
}

TEST(Seams, AMapOfOnePieceStaysAsItIs) {
  GroundGrid grid = two_patches(1);
  for (std::uint16_t& s : grid.source.samples) s = s == 0 ? 0 : 1;
  const GroundGrid before = grid;
  close_seams(grid);
  EXPECT_EQ(grid.ortho.samples, before.ortho.samples);
  EXPECT_FALSE(std::isfinite(grid.height.at(gap, 30)));
}

}  // namespace
}  // namespace ilp::map
