#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/world/terrain.hpp"
#include "sim/world/world_params.hpp"
#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

/// The ground that a nadir camera of 550 px focal length and 640x480 px sees in 20 frames.
Rectangle strip(const WorldPreset& preset) {
  const double h = preset.altitude_m;
  return {-0.58 * h, -0.44 * h, 1.5 * h, 0.44 * h};
}

double relief(const SurfacePatch& patch) {
  const auto [low, high] = std::minmax_element(patch.height_m.begin(), patch.height_m.end());
  return *high - *low;
}

/// Standard deviation of the light at posts over its mean.
double contrast(const std::vector<float>& light) {
  double sum = 0;
  double squares = 0;
  for (const float value : light) {
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const auto count = static_cast<double>(light.size());
  return std::sqrt(squares / count - sum * sum / (count * count)) / (sum / count);
}

TEST(WorldPresets, ReliefIsInProportionToTheAltitude) {
  struct Expected {
    const char* name;
    double least, most;  // share of the altitude
  };
  constexpr Expected expected[] = {
      {"testbed", 0.01, 0.08}, {"mars-plains", 0.05, 0.15}, {"mars-canyon", 0.18, 0.35}, {"titan-shore", 0.02, 0.10},
      {"flat", 0, 0},
  };
  ASSERT_EQ(std::size(expected), world_presets().size());
  for (const auto& [name, least, most] : expected) {
    const WorldPreset& preset = world_preset(name);
    const Terrain terrain(preset.world);
    EXPECT_LT(terrain.highest(), 0.6 * preset.altitude_m) << name;
    const double share = relief(terrain.patch(strip(preset))) / preset.altitude_m;
    EXPECT_GE(share, least) << name;
    EXPECT_LE(share, most) << name;
  }
}

// Ground that a camera cannot resolve, or posts that it sees as squares, would spoil every test that uses the preset.
TEST(WorldPresets, PostsAreAsLargeAsGroundPixelsAndHaveContrast) {
  for (const WorldPreset& preset : world_presets()) {
    const double pixel = preset.altitude_m / 550;
    EXPECT_GT(preset.world.post_spacing_m, 0.5 * pixel) << preset.name;
    EXPECT_LT(preset.world.post_spacing_m, 1.5 * pixel) << preset.name;
    // Land only, where there is liquid.
    const double h = preset.altitude_m;
    const Terrain terrain(preset.world);
    EXPECT_GT(contrast(terrain.patch({0, 0, 0.5 * h, 0.4 * h}).radiance), 0.1) << preset.name;
  }
}

TEST(WorldPresets, FlatIsThePlaneZero) {
  const Terrain terrain(world_preset("flat").world);
  EXPECT_EQ(terrain.lowest(), 0);
  EXPECT_EQ(terrain.highest(), 0);
  for (const float height : terrain.patch({-20, -20, 20, 20}).height_m) ASSERT_EQ(height, 0.0F);
  EXPECT_EQ(terrain.height(3.3, 4.4), 0);
}

// The shore is seen, and land enough beside it to be followed.
TEST(WorldPresets, TitanHasDarkLevelLiquidOnOneSide) {
  const WorldPreset& preset = world_preset("titan-shore");
  const Terrain terrain(preset.world);
  const SurfacePatch patch = terrain.patch(strip(preset));
  const auto level = static_cast<float>(preset.world.liquid_level_m);
  std::vector<float> liquid;
  std::vector<float> land;
  std::size_t near_side = 0;
  for (std::int32_t j = 0; j < patch.rows; ++j) {
    for (std::int32_t i = 0; i < patch.columns; ++i) {
      const std::size_t at = patch.index(i, j);
      ASSERT_GE(patch.height_m[at], level);
      (patch.height_m[at] == level ? liquid : land).push_back(patch.radiance[at]);
      if (patch.height_m[at] == level && (patch.first_j + j) * patch.spacing_m < 0) ++near_side;
    }
  }
  const double share = static_cast<double>(liquid.size()) / static_cast<double>(patch.height_m.size());
  EXPECT_GT(share, 0.1);
  EXPECT_LT(share, 0.5);
  EXPECT_GT(near_side, 9 * liquid.size() / 10);
  std::nth_element(liquid.begin(), liquid.begin() + static_cast<std::ptrdiff_t>(liquid.size() / 2), liquid.end());
  std::nth_element(land.begin(), land.begin() + static_cast<std::ptrdiff_t>(land.size() / 2), land.end());
  EXPECT_LT(liquid[liquid.size() / 2], 0.5F * land[land.size() / 2]);
  EXPECT_LT(contrast(terrain.patch({0, -85, 60, -75}).radiance), 0.03);
  EXPECT_EQ(terrain.detail(30, -80, preset.world.liquid_level_m, 0.36), 1);
  EXPECT_NE(terrain.detail(30.1, 20.2, 5, 0.36), 1);
}

TEST(WorldPresets, UnknownNameListsTheNames) {
  const auto refusal = test::error_of<std::invalid_argument>([] { static_cast<void>(world_preset("venus")); });
  for (const WorldPreset& preset : world_presets()) EXPECT_TRUE(test::says(refusal, std::string(preset.name)));
}

}  // namespace
}  // namespace ilp::world
