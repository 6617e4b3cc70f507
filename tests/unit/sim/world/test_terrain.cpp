#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/world/terrain.hpp"
#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

TEST(Terrain, PostsOfAPatchHaveTheHeightsOfTheGround) {
  const Terrain terrain{WorldParams{}};
  const SurfacePatch patch = terrain.patch({-31.3, 12.1, -10.2, 27.9});
  Rng rng(7);
  for (int n = 0; n < 200; ++n) {
    const auto i = static_cast<std::int32_t>(rng.below(static_cast<std::uint32_t>(patch.columns)));
    const auto j = static_cast<std::int32_t>(rng.below(static_cast<std::uint32_t>(patch.rows)));
    const double x = (patch.first_i + i) * patch.spacing_m;
    const double y = (patch.first_j + j) * patch.spacing_m;
    ASSERT_NEAR(patch.height_m[patch.index(i, j)], terrain.height(x, y), 1e-5) << x << " " << y;
  }
}

// Frames see the same ground through different patches: a seam would be a change of the scene.
TEST(Terrain, OverlappingPatchesAgreeBitForBit) {
  const Terrain terrain{WorldParams{}};
  const SurfacePatch a = terrain.patch({0, 0, 40, 30});
  const SurfacePatch b = terrain.patch({17.7, 9.9, 60, 50});
  int compared = 0;
  for (std::int32_t j = b.first_j; j < a.first_j + a.rows; ++j) {
    for (std::int32_t i = b.first_i; i < a.first_i + a.columns; ++i, ++compared) {
      const std::size_t in_a = a.index(i - a.first_i, j - a.first_j);
      const std::size_t in_b = b.index(i - b.first_i, j - b.first_j);
      ASSERT_EQ(a.height_m[in_a], b.height_m[in_b]);
      ASSERT_EQ(a.radiance[in_a], b.radiance[in_b]);
    }
  }
  EXPECT_GT(compared, 10000);
}

TEST(Terrain, ReliefIsAboutWhatWasAskedFor) {
  for (const double relief : {6.0, 12.0, 24.0}) {
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      WorldParams params;
      params.seed = seed;
      params.relief_m = relief;
      params.post_spacing_m = 1;
      params.shortest_wavelength_m = 2;
      params.crater_density = 0;
      params.smallest_crater_radius_m = params.largest_crater_radius_m = 2;
      params.smallest_rock_radius_m = params.largest_rock_radius_m = 1;
      params.rock_density = 0;
      const SurfacePatch patch = Terrain(params).patch({-60, -60, 460, 60});
      const auto [low, high] = std::minmax_element(patch.height_m.begin(), patch.height_m.end());
      sum += (*high - *low) / 3;
      EXPECT_LE(*high, relief);
      EXPECT_GE(*low, -relief);
    }
    EXPECT_GT(sum, 0.6 * relief);
    EXPECT_LT(sum, 1.3 * relief);
  }
}

TEST(Terrain, NormalIsPerpendicularToTheSurface) {
  const Terrain terrain{WorldParams{}};
  const double step = terrain.params().post_spacing_m;
  Rng rng(3);
  for (int n = 0; n < 50; ++n) {
    const double x = 100 * rng.uniform();
    const double y = 100 * rng.uniform();
    const Vec3 normal = terrain.normal(x, y);
    EXPECT_NEAR(normal.norm(), 1, 1e-12);
    EXPECT_GT(normal.z(), 0);
    const Vec3 along_x(2 * step, 0, terrain.height(x + step, y) - terrain.height(x - step, y));
    const Vec3 along_y(0, 2 * step, terrain.height(x, y + step) - terrain.height(x, y - step));
    EXPECT_NEAR(normal.dot(along_x), 0, 1e-9);
    EXPECT_NEAR(normal.dot(along_y), 0, 1e-9);
  }
}

std::string complaint(const WorldParams& params) {
  return test::error_of<std::invalid_argument>([&] { const Terrain terrain(params); });
}

TEST(Terrain, ErrorsNameTheField) {
  WorldParams params{.sun_elevation_rad = std::nan("")};
  EXPECT_TRUE(test::says(complaint(params), "sun_elevation_rad"));
}

TEST(Terrain, EveryParameterIsCheckedAndNamed) {
  WorldParams defaults;
  for (std::size_t k = 0; k < parameters(defaults).size(); ++k) {
    WorldParams params;
    const Parameter parameter = parameters(params)[k];
    double* const* const field = std::get_if<double*>(&parameter.field);
    if (field == nullptr) continue;
    **field = std::nan("");
    EXPECT_TRUE(test::says(complaint(params), std::string(parameter.name)));
  }
}

TEST(Terrain, ParametersThatContradictEachOtherAreRefused) {
  const auto refused = [](auto change, const std::string& field) {
    WorldParams params;
    change(params);
    return test::says(complaint(params), field);
  };
  EXPECT_TRUE(refused([](WorldParams& w) { w.shortest_wavelength_m = 0.3; }, "shortest_wavelength_m"));
  EXPECT_TRUE(refused([](WorldParams& w) { w.largest_crater_radius_m = 1; }, "largest_crater_radius_m"));
  EXPECT_TRUE(refused([](WorldParams& w) { w.smallest_rock_radius_m = 0.1; }, "smallest_rock_radius_m"));
  EXPECT_TRUE(refused(
      [](WorldParams& w) {
        w.channel_depth_m = 1;
        w.channel_spacing_m = 20;
      },
      "channel_spacing_m"));
  EXPECT_TRUE(refused(
      [](WorldParams& w) {
        w.dune_height_m = 0.1;
        w.dune_wavelength_m = 1;
      },
      "dune_wavelength_m"));
}

/// Mean square difference of heights `lag` posts apart along rows.
double structure_function(const SurfacePatch& patch, std::int32_t lag) {
  double sum = 0;
  for (std::int32_t j = 0; j < patch.rows; ++j) {
    for (std::int32_t i = 0; i + lag < patch.columns; ++i) {
      const double step = patch.height_m[patch.index(i + lag, j)] - patch.height_m[patch.index(i, j)];
      sum += step * step;
    }
  }
  return sum / (static_cast<double>(patch.columns - lag) * patch.rows);
}

// Fractional Brownian ground: the mean square step grows as its length to 2 H (B. B. Mandelbrot, J. W. Van Ness, 1968).
TEST(Terrain, RoughnessGrowsWithTheScaleAsTheHurstExponentSays) {
  for (const double hurst : {0.3, 0.5, 0.7, 0.85}) {
    double slope = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      WorldParams params;
      params.seed = seed;
      params.hurst = hurst;
      params.longest_wavelength_m = 512;
      params.shortest_wavelength_m = 1;
      params.post_spacing_m = 0.5;
      params.crater_density = 0;
      params.rock_density = 0;
      const SurfacePatch patch = Terrain(params).patch({0, 0, 700, 300});
      slope += 0.5 * std::log2(structure_function(patch, 32) / structure_function(patch, 8)) / 2 / 3;
    }
    EXPECT_NEAR(slope, hurst, 0.08);
  }
}

TEST(Terrain, RuggednessScalesEveryHeightAndNothingElse) {
  WorldParams params{.dune_height_m = 0.5, .channel_depth_m = 2, .terrace_step_m = 3};
  const Rectangle area{10, 20, 40, 50};
  const SurfacePatch whole = Terrain(params).patch(area);
  params.ruggedness = 0.25;
  const Terrain quarter(params);
  const SurfacePatch low = quarter.patch(area);
  params.ruggedness = 0;
  const Terrain plane(params);
  const SurfacePatch flat = plane.patch(area);
  double brightest = 0;
  double darkest = 10;
  for (std::size_t k = 0; k < whole.height_m.size(); ++k) {
    ASSERT_NEAR(low.height_m[k], 0.25F * whole.height_m[k], 1e-6);
    ASSERT_GE(low.height_m[k], quarter.lowest() - 1e-6);
    ASSERT_LE(low.height_m[k], quarter.highest() + 1e-6);
    ASSERT_EQ(flat.height_m[k], 0);
    brightest = std::max<double>(brightest, flat.radiance[k]);
    darkest = std::min<double>(darkest, flat.radiance[k]);
  }
  EXPECT_EQ(plane.height(12.3, 45.6), 0);
  EXPECT_GT(brightest, 1.5 * darkest);
}

// Tiles are made in whatever order threads ask for them; one tile asked for by all must be made once and whole.
TEST(Terrain, PatchesDoNotDependOnThreadsOrOrder) {
  std::vector<Rectangle> areas;
  for (int k = 0; k < 12; ++k) areas.push_back({-60.0 + 7 * k, -30, -20.0 + 7 * k, 10});
  const Terrain alone{WorldParams{}};
  std::vector<SurfacePatch> expected;
  for (auto area = areas.rbegin(); area != areas.rend(); ++area) expected.push_back(alone.patch(*area));
  std::reverse(expected.begin(), expected.end());
  const Terrain shared{WorldParams{}};
  std::vector<SurfacePatch> found(areas.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        for (std::size_t k = t; k < areas.size(); k += 4) found[k] = shared.patch(areas[k]);
      });
    }
  }
  for (std::size_t k = 0; k < areas.size(); ++k) {
    ASSERT_EQ(expected[k].height_m, found[k].height_m);
    ASSERT_EQ(expected[k].radiance, found[k].radiance);
  }
}

// More tiles than are kept: what was forgotten comes back the same.
TEST(Terrain, GroundThatWasLeftIsTheSameOnReturn) {
  WorldParams params{.shortest_wavelength_m = 40, .post_spacing_m = 1, .crater_density = 0, .rock_density = 0};
  const Terrain terrain(params);
  const Rectangle home{0, 0, 100, 100};
  const SurfacePatch before = terrain.patch(home);
  for (int k = 1; k <= 8; ++k) static_cast<void>(terrain.patch({1000.0 * k, 0, 1000.0 * k + 999, 1300}));
  const SurfacePatch after = terrain.patch(home);
  EXPECT_EQ(before.height_m, after.height_m);
  EXPECT_EQ(before.radiance, after.radiance);
}

TEST(Terrain, ViewsThatAreTooLargeOrTooFarAreRefused) {
  const Terrain terrain{WorldParams{}};
  EXPECT_THROW(static_cast<void>(terrain.patch({0, 0, 1e5, 1e5})), std::runtime_error);
  EXPECT_THROW(static_cast<void>(terrain.patch({1e12, 0, 1e12 + 10, 10})), std::runtime_error);
  EXPECT_THROW(static_cast<void>(terrain.height(std::nan(""), 0)), std::runtime_error);
}

}  // namespace
}  // namespace ilp::world
