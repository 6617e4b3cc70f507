#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/world/landforms.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::sim {
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

TEST(Terrain, ErrorsNameTheField) {
  WorldParams params;
  params.sun_elevation_rad = std::nan("");
  try {
    const Terrain terrain(params);
    FAIL() << "a sun of unknown height was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("sun_elevation_rad"), std::string::npos) << error.what();
  }
}

// Pike (1977): a new crater is 0.2 diameters deep below the plain, its rim 0.04 diameters above it.
TEST(Landforms, NewCraterHasBowlRimAndEjecta) {
  const Crater crater{5, -3, 10, 1};
  const auto height = [&](double radii) { return crater_relief(crater, 5 + 10 * radii, -3).height_m; };
  EXPECT_NEAR(height(0), -4, 0.05);
  double crest = 0;
  double crest_at = 0;
  for (double r = 0; r < 3; r += 0.01) {
    if (height(r) > crest) {
      crest = height(r);
      crest_at = r;
    }
  }
  EXPECT_NEAR(crest_at, 1, 0.2);
  EXPECT_GT(crest, 0.4);
  EXPECT_LT(crest, 0.9);
  EXPECT_GT(height(1.8), 0);
  EXPECT_EQ(height(2.6), 0);
}

TEST(Landforms, RockIsAsHighAndWideAsStated) {
  Rock rock;
  rock.axis_x_per_m = 0.5;
  rock.cross_y_per_m = 1;
  rock.height_m = 0.7;
  EXPECT_DOUBLE_EQ(rock_relief(rock, 0, 0).height_m, 0.7);
  EXPECT_GT(rock_relief(rock, 1.9, 0).height_m, 0);
  EXPECT_EQ(rock_relief(rock, 0, 1.1).height_m, 0);
}

}  // namespace
}  // namespace ilp::sim
