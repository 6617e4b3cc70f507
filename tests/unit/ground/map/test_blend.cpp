// Pieces that do not agree go over into each other, and the ground is not worse for it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/ground/map/blend.hpp"
#include "sim/ground/map/seam_measure.hpp"

namespace ilp::map {
namespace {

constexpr std::int32_t side = 200, border = 100;

double ground(std::int32_t x, std::int32_t y) {
  return 3 * std::sin(0.05 * x) + 2 * std::cos(0.04 * y + 0.02 * x);
}

/// Rolling ground, measured by two pieces that meet at column 100: with noise, the second one with an offset, and the
/// last cells of both err twice as much.
struct TwoPatches {
  host::Raster<float> values{side, side}, sigma{side, side};
  host::Raster<std::uint16_t> source{side, side};

  TwoPatches(double offset, float sigma_of_second) {
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0, 0.05);
    for (std::int32_t y = 0; y < side; ++y) {
      for (std::int32_t x = 0; x < side; ++x) {
        const bool second = x >= border;
        const double error = (std::abs(x - border) < 3 ? 4 : 1) * noise(random);
        values.at(x, y) = static_cast<float>(ground(x, y) + error + (second ? offset : 0));
        sigma.at(x, y) = second ? sigma_of_second : 0.2F;
        source.at(x, y) = second ? 2 : 1;
      }
    }
  }
  [[nodiscard]] Roughness roughness() const {
    MapTile tile;
    tile.height = values;
    tile.ortho = host::Raster<std::uint8_t>(side, side);
    tile.source = source;
    Mosaic mosaic{{0, 0, 1, side, side}, 1, 1, [&](std::int32_t, std::int32_t) { return tile; }, side, 0, 0, {}, {}};
    return measure_seams(mosaic).height;
  }
  /// Mean squared error over the 20 columns before or after the border, with that part of the offset that is not known.
  [[nodiscard]] double error(std::int32_t from, std::int32_t to, double bias) const {
    double sum = 0;
    for (std::int32_t y = 0; y < side; ++y) {
      for (std::int32_t x = from; x < to; ++x) sum += std::pow(values.at(x, y) - ground(x, y) - bias, 2);
    }
    return std::sqrt(sum / (side * (to - from)));
  }
};

TEST(Blend, ABorderIsAsSmoothAsTheRestAndNoFurtherFromTheGround) {
  TwoPatches patches(1, 0.2F);
  EXPECT_GT(patches.roughness().ratio(), 3);
  // Which piece is right nobody knows: the middle between both is the best guess about the border.
  const double before = patches.error(border - 20, border + 20, 0.5);
  blend_patches(patches.source, patches.sigma, 0.2F, {}, patches.values);
  EXPECT_LT(patches.roughness().ratio(), 1.1);
  EXPECT_LT(patches.error(border - 20, border + 20, 0.5), before);
  EXPECT_LT(patches.error(border - 2, border + 2, 0.5), 0.15);
}

TEST(Blend, PiecesKeepTheirOwnHeightsFarFromTheBorderAndTheBetterOneBendsLess) {
  TwoPatches patches(1, 0.6F);
  const host::Raster<float> before = patches.values;
  blend_patches(patches.source, patches.sigma, 0.2F, {}, patches.values);
  double first = 0, second = 0;
  for (std::int32_t y = 20; y < side - 20; ++y) {
    first += patches.values.at(border - 5, y) - before.at(border - 5, y);
    second += before.at(border + 4, y) - patches.values.at(border + 4, y);
    ASSERT_EQ(patches.values.at(border - blend_reach_cells - 2, y), before.at(border - blend_reach_cells - 2, y));
    ASSERT_EQ(patches.values.at(border + blend_reach_cells + 2, y), before.at(border + blend_reach_cells + 2, y));
  }
  EXPECT_GT(first, 0);
  EXPECT_GT(second, 2 * first);
}

TEST(Blend, APartOfTheMapWithItsMarginIsBlendedAsTheWhole) {
  TwoPatches whole(1, 0.3F);
  constexpr std::int32_t left = 90, top = 60, size = 40, with_margin = size + 2 * blend_reach_cells;
  const auto part = [&](const auto& raster) {
    return host::part_of(raster, left - blend_reach_cells, top - blend_reach_cells, with_margin, with_margin);
  };
  host::Raster<float> values = part(whole.values);
  blend_patches(part(whole.source), part(whole.sigma), 0.2F, {}, values);
  blend_patches(whole.source, whole.sigma, 0.2F, {}, whole.values);
  for (std::int32_t y = 0; y < size; ++y) {
    for (std::int32_t x = 0; x < size; ++x) {
      ASSERT_NEAR(values.at(blend_reach_cells + x, blend_reach_cells + y), whole.values.at(left + x, top + y), 0.01);
    }
  }
}

TEST(Blend, OnePieceAndEmptyGroundStayAsTheyAre) {
  TwoPatches patches(0, 0.2F);
  for (auto& s : patches.source.samples) s = s == 2 ? 0 : 1;
  const host::Raster<float> before = patches.values;
  blend_patches(patches.source, patches.sigma, 0.2F, {}, patches.values);
  EXPECT_EQ(patches.values.samples, before.samples);
  EXPECT_EQ(patches.roughness().ratio(), 0) << "there is no border";
}

TEST(SeamMeasure, AStepBetweenPiecesIsMeasuredByItsHeight) {
  TwoPatches patches(0, 0.2F);
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x)
      patches.values.at(x, y) = x >= border ? 3.0F : 0.1F * static_cast<float>(x % 2);
  }
  // Along a row four of five samples have the border in reach, and two of them the step.
  const Roughness roughness = patches.roughness();
  EXPECT_EQ(roughness.border_samples, 4U * side);
  EXPECT_NEAR(roughness.border, std::sqrt((0.2 * 0.2 + 2.8 * 2.8 + 2.9 * 2.9) / 4), 1e-6);
  EXPECT_LT(roughness.other, 0.2);
}

TEST(SeamMeasure, AStepOfGreyIsComparedWithGroundBesideTheBorder) {
  // Steep grey about the border, flat grey far from it, and a step of 30 at the border.
  MapTile tile;
  tile.height = host::Raster<float>(side, side);
  tile.source = host::Raster<std::uint16_t>(side, side);
  tile.ortho = host::Raster<std::uint8_t>(side, side, 100);
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x) {
      const bool second = x >= border;
      tile.source.at(x, y) = second ? 2 : 1;
      if (std::abs(x - border) < 60) tile.ortho.at(x, y) = static_cast<std::uint8_t>(x + (second ? 30 : 0));
    }
  }
  Mosaic mosaic{{0, 0, 1, side, side}, 1, 1, [&](std::int32_t, std::int32_t) { return tile; }, side, 0, 0, {}, {}};
  const Roughness step = measure_seams(mosaic).grey_step;
  EXPECT_NEAR(step.other, 16, 1e-9) << "the slope over the 16 cells between the two means";
  EXPECT_NEAR(step.border, 46, 1e-9) << "the slope and the step";
}

}  // namespace
}  // namespace ilp::map
