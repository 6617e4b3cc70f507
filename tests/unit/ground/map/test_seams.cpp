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
GroundGrid two_pieces(std::int32_t gap_columns) {
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
  GroundGrid grid = two_pieces(2);
  EXPECT_EQ(grid_surface(grid, 1, {}).faces.size(), whole - 2 * 3 * (height - 1));
  close_seams(grid);
  const SurfaceMesh surface = grid_surface(grid, 1, {});
  EXPECT_EQ(surface.vertices.size(), static_cast<std::size_t>(width) * height);
  EXPECT_EQ(surface.faces.size(), whole);
  for (const SurfaceVertex& v : surface.vertices) ASSERT_NEAR(v.z, 0.1 * v.x / grid.cell, 1e-4);
}

TEST(Seams, AWallIsNotPartOfTheSurfaceAndTheStrideBoundsTheVertices) {
  GroundGrid grid = two_pieces(0);
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
    GroundGrid grid = two_pieces(columns);
    close_seams(grid);
    for (std::int32_t x = gap; x < gap + columns; ++x) {
      EXPECT_NEAR(grid.height.at(x, 30), 0.1 * x, 1e-5);
      EXPECT_GT(grid.ortho.at(x, 30), 50);
      EXPECT_EQ(grid.count.at(x, 30), 0) << "nothing was measured here, and the count says so";
    }
  }
}

TEST(Seams, WideGapsHolesInsideAPieceAndCliffsStay) {
  GroundGrid wide = two_pieces(5);
  close_seams(wide);
  EXPECT_FALSE(std::isfinite(wide.height.at(gap + 2, 30)));

  GroundGrid hole = two_pieces(1);
  hole.source.at(20, 20) = 0;
  hole.height.at(20, 20) = std::numeric_limits<float>::quiet_NaN();
  close_seams(hole);
  EXPECT_FALSE(std::isfinite(hole.height.at(20, 20)));

  GroundGrid cliff = two_pieces(1);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = gap + 1; x < width; ++x) cliff.height.at(x, y) += 30;
  }
  close_seams(cliff);
  EXPECT_FALSE(std::isfinite(cliff.height.at(gap, 30)));
}

void balance(GroundGrid& grid, const std::vector<std::int64_t>& keyframes) {
  SeamRatios ratios;
  add_seam_ratios(grid, keyframes, 0, ratios);
  std::map<std::int64_t, ShownPiece> pieces;
  for (std::size_t i = 0; i < grid.source.samples.size(); ++i) {
    if (grid.source.samples[i] == 0) continue;
    ShownPiece& piece = pieces[keyframes[grid.source.samples[i] - 1U]];
    ++piece.cells;
    piece.grey += grid.ortho.samples[i];
  }
  const std::map<std::int64_t, double> gains = balance_exposures(ratios, pieces);
  for (std::size_t i = 0; i < grid.ortho.samples.size(); ++i) {
    if (grid.source.samples[i] == 0) continue;
    const double grey = grid.ortho.samples[i] * gains.at(keyframes[grid.source.samples[i] - 1U]) + 0.5;
    grid.ortho.samples[i] = static_cast<std::uint8_t>(std::min(grey, 255.0));
  }
}

TEST(Seams, DifferentExposuresAreBalanced) {
  GroundGrid grid = two_pieces(1);
  close_seams(grid);
  // Ids in the other order than sources.
  balance(grid, {9, 4});
  double sums[2] = {0, 0};
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < 40; ++x) {
      sums[0] += grid.ortho.at(x, y);
      sums[1] += grid.ortho.at(x + gap, y);
    }
  }
  EXPECT_NEAR(sums[0] / sums[1], 1, 0.03);
  // Neither piece is taken for the right one.
  EXPECT_NEAR(sums[0] / (40 * height), 130 / std::sqrt(2.0), 6);
}

constexpr std::int32_t strip_pieces = 24;
constexpr std::int32_t piece_columns = 30;
/// Exposures of a camera whose frames go from 180 to 66 and back to 110.
double strip_exposure(std::int32_t piece) {
  constexpr std::int32_t darkest = 16;
  return piece < darkest ? 180 - (180.0 - 66) * piece / darkest
                         : 66 + (110.0 - 66) * (piece - darkest) / (strip_pieces - 1 - darkest);
}

/// Ground of one brightness on average under a lens that is a few per cent darker at one edge of the piece.
GroundGrid strip_of_pieces(double darker_edge, double albedo_of_the_second_half) {
  GroundGrid grid;
  grid.cell = 0.5;
  const std::int32_t columns = strip_pieces * piece_columns, rows = 60;
  grid.height = host::Raster<float>(columns, rows);
  grid.ortho = host::Raster<std::uint8_t>(columns, rows);
  grid.count = host::Raster<std::uint16_t>(columns, rows);
  grid.source = host::Raster<std::uint16_t>(columns, rows);
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < columns; ++x) {
      const std::int32_t piece = x / piece_columns;
      const double lens = 1 - darker_edge * (x % piece_columns) / (piece_columns - 1);
      const double ground = (1 + 0.02 * ((x * 7 + y * 13) % 11 - 5)) *
                            (x >= piece_columns * (strip_pieces + 1) / 2 ? albedo_of_the_second_half : 1);
      grid.ortho.at(x, y) = static_cast<std::uint8_t>(std::lround(strip_exposure(piece) * lens * ground));
      grid.count.at(x, y) = 1;
      grid.source.at(x, y) = static_cast<std::uint16_t>(piece + 1);
    }
  }
  return grid;
}

std::vector<double> piece_means(const GroundGrid& grid) {
  std::vector<double> means(strip_pieces, 0);
  for (std::size_t i = 0; i < grid.ortho.samples.size(); ++i)
    means[grid.source.samples[i] - 1U] += grid.ortho.samples[i];
  for (double& mean : means) mean /= static_cast<double>(piece_columns * grid.ortho.height);
  return means;
}

std::vector<double> balanced_means(GroundGrid grid) {
  std::vector<std::int64_t> ids;
  for (std::int64_t i = 0; i < strip_pieces; ++i) ids.push_back(10 + 3 * i);
  balance(grid, ids);
  return piece_means(grid);
}

TEST(Seams, BrightnessDoesNotDriftAlongAStripWhoseImagesAreDarkerAtOneEdge) {
  const std::vector<double> means = balanced_means(strip_of_pieces(0.06, 1));
  const auto [darkest, brightest] = std::minmax_element(means.begin(), means.end());
  // The errors of 23 seams add up to a factor of 2.4, and the exposures differ by a factor of 2.7.
  EXPECT_LT(*brightest / *darkest, 1.4);
  // Far from the ends nothing is left of either.
  const auto [dark, bright] = std::minmax_element(means.begin() + 8, means.end() - 8);
  EXPECT_LT(*bright / *dark, 1.05);
}

TEST(Seams, AKeyframeAtTheEndOfALongStripDoesNotChangeTheBrightnessOfItsBeginning) {
  const auto gains_of = [](std::int64_t keyframes) {
    SeamRatios ratios;
    std::map<std::int64_t, ShownPiece> pieces;
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      const auto grey = static_cast<std::uint64_t>(90 + 13 * (id % 5));
      pieces[id] = {1000, 1000 * grey};
      if (id > 1) ratios[{id - 1, id}].add(static_cast<std::int32_t>(7 * (id % 3) - 8), 400);
    }
    return balance_exposures(ratios, pieces);
  };
  for (const std::int64_t keyframes : {200, 500}) {
    const auto before = gains_of(keyframes), after = gains_of(keyframes + 1);
    for (std::int64_t id = 1; id <= keyframes - 80; ++id) EXPECT_NEAR(before.at(id), after.at(id), 1e-9) << id;
    EXPECT_GT(std::fabs(before.at(keyframes) - after.at(keyframes)), 1e-3);
  }
}

TEST(Seams, BrightGroundBesideDarkGroundStaysBright) {
  const std::vector<double> means = balanced_means(strip_of_pieces(0, 1.3));
  // The ground changes in the middle of the piece between these two.
  EXPECT_GT(means[strip_pieces / 2 + 1] / means[strip_pieces / 2 - 1], 1.12);
}

TEST(Seams, AMapOfOnePieceStaysAsItIs) {
  GroundGrid grid = two_pieces(1);
  for (std::uint16_t& s : grid.source.samples) s = s == 0 ? 0 : 1;
  const GroundGrid before = grid;
  close_seams(grid);
  balance(grid, {3});
  EXPECT_EQ(grid.ortho.samples, before.ortho.samples);
  EXPECT_FALSE(std::isfinite(grid.height.at(gap, 30)));
}

}  // namespace
}  // namespace ilp::map
