#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/world/landforms.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {
namespace {

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
  Rock rock{.axis_x_per_m = 0.5, .cross_y_per_m = 1, .height_m = 0.7};
  EXPECT_DOUBLE_EQ(rock_relief(rock, 0, 0).height_m, 0.7);
  EXPECT_GT(rock_relief(rock, 1.9, 0).height_m, 0);
  EXPECT_EQ(rock_relief(rock, 0, 1.1).height_m, 0);
}

// The exponent of the cumulative distribution: least squares over octaves of log N(> r), within and between classes.
TEST(Landforms, CratersFollowTheirSizeFrequencyDistribution) {
  for (const double exponent : {1.5, 2.0, 3.2}) {
    Rng rng(5);
    std::vector<Crater> craters;
    for (const SizeClass& size : size_classes(32, 1, exponent, 3.2, 0.7, rng)) {
      find_craters(size, {0, 0, 2500, 2500}, craters);
    }
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    int count = 0;
    for (double radius = 1.2; radius < 13; radius *= 1.3) {
      const auto larger =
          std::count_if(craters.begin(), craters.end(), [&](const Crater& crater) { return crater.radius_m > radius; });
      // N(> r) is cut at the largest radius, so that the law holds for N + a constant.
      const double all = std::pow(radius, -exponent) - std::pow(32.0, -exponent);
      const double x = std::log(radius);
      const double y = std::log(static_cast<double>(larger) * std::pow(radius, -exponent) / all);
      sx += x;
      sy += y;
      sxx += x * x;
      sxy += x * y;
      ++count;
    }
    EXPECT_NEAR((count * sxy - sx * sy) / (count * sxx - sx * sx), -exponent, 0.12);
  }
}

WorldParams bare(double post_spacing_m) {
  WorldParams world;
  world.post_spacing_m = post_spacing_m;
  world.shortest_wavelength_m = 4 * post_spacing_m;
  world.relief_m = 1e-6;
  world.crater_density = 0;
  world.rock_density = 0;
  return world;
}

TEST(Landforms, DunesHaveTheirWavelengthHeightAndSteepLee) {
  WorldParams world = bare(0.25);
  world.dune_height_m = 1.5;
  world.dune_wavelength_m = 20;
  world.dune_direction_rad = 0;
  world.dune_asymmetry = 0.6;
  const Terrain terrain(world);
  const SurfacePatch patch = terrain.patch({0, 0, 2000, 1});
  int crests = 0;
  double rising = 0;
  double falling = 0;
  for (std::int32_t i = 1; i + 1 < patch.columns; ++i) {
    const float before = patch.height_m[patch.index(i - 1, 0)];
    const float here = patch.height_m[patch.index(i, 0)];
    const float after = patch.height_m[patch.index(i + 1, 0)];
    crests += here > before && here >= after && here > 0.1F ? 1 : 0;
    (here > before ? rising : falling) += 1;
  }
  EXPECT_NEAR(crests, 100, 8);
  // The crest stands at 0.74 of the way along the wind.
  EXPECT_NEAR(rising / (rising + falling), 0.74, 0.04);
  const auto [low, high] = std::minmax_element(patch.height_m.begin(), patch.height_m.end());
  EXPECT_GT(*high - *low, 1.2F);
  EXPECT_LE(*high - *low, 1.5F);
}

TEST(Landforms, ChannelsAreAsDeepAndWideAndFarApartAsStated) {
  WorldParams world = bare(0.5);
  world.channel_depth_m = 5;
  world.channel_width_m = 16;
  world.channel_spacing_m = 100;
  world.channel_direction_rad = 0;
  world.channel_meander = 0;
  const Terrain terrain(world);
  for (double y = 0; y < 300; y += 0.5) {
    const double from_centre = std::fabs(y - 100 * std::floor(y / 100) - 50);
    const double height = terrain.height(33, y);
    if (from_centre <= 4) {
      EXPECT_NEAR(height, -5, 1e-4) << y;
    }
    if (from_centre >= 8) {
      EXPECT_NEAR(height, 0, 1e-4) << y;
    }
  }
}

TEST(Landforms, MeandersKeepTheChannelsWidthAndStayApart) {
  WorldParams world = bare(0.5);
  world.channel_depth_m = 5;
  world.channel_width_m = 16;
  world.channel_spacing_m = 150;
  world.channel_direction_rad = 0.7;
  world.channel_meander = 1;
  const Terrain terrain(world);
  const SurfacePatch patch = terrain.patch({-400, -400, 400, 400});
  double wet = 0;
  for (const float height : patch.height_m) wet += height < -2.5F ? 1 : 0;
  // Cut at half its depth a channel is 3/4 of its width; bends add length.
  const double straight = 0.75 * 16 / 150;
  EXPECT_GT(wet / static_cast<double>(patch.height_m.size()), straight);
  EXPECT_LT(wet / static_cast<double>(patch.height_m.size()), 1.6 * straight);
}

TEST(Landforms, TerraceIsContinuousRisingAndSteepInTheMiddle) {
  for (double h = -3; h < 3; h += 0.01) {
    EXPECT_NEAR(terrace(h, 1, 0), h, 1e-12);
    EXPECT_GE(terrace(h + 0.01, 1, 0.8), terrace(h, 1, 0.8));
    EXPECT_LT(terrace(h + 1e-6, 1, 0.8) - terrace(h, 1, 0.8), 1e-5);
  }
  EXPECT_NEAR(terrace(2, 1, 0.8), 2, 1e-12);
  EXPECT_LT(terrace(2.3, 1, 0.8), 2.06);
  EXPECT_GT(terrace(2.7, 1, 0.8), 2.94);
}

// What is said to have been planted must stand there.
TEST(Landforms, FeaturesLieWhereTheGroundShowsThem) {
  WorldParams world = bare(0.25);
  world.crater_density = 0.1;
  world.smallest_crater_radius_m = 10;
  const Terrain terrain(world);
  int craters = 0;
  for (const PlantedFeature& feature : terrain.features({0, 0, 1500, 1500})) {
    ASSERT_EQ(feature.kind, FeatureKind::crater);
    EXPECT_GT(feature.radius_m, 4.9);
    const double rim = terrain.height(feature.x + 1.05 * feature.radius_m, feature.y) +
                       terrain.height(feature.x - 1.05 * feature.radius_m, feature.y);
    craters += 0.5 * rim > terrain.height(feature.x, feature.y) + 0.05 * feature.radius_m ? 1 : 0;
  }
  EXPECT_GT(craters, 40);
}

TEST(Landforms, ChannelAndScarpPointsLieOnThem) {
  WorldParams world = bare(0.5);
  world.channel_depth_m = 4;
  world.channel_width_m = 16;
  for (const PlantedFeature& feature : Terrain(world).features({-200, -200, 200, 200})) {
    ASSERT_EQ(feature.kind, FeatureKind::channel);
    EXPECT_NEAR(Terrain(world).height(feature.x, feature.y), -4, 1e-3);
  }
  world = bare(0.5);
  world.relief_m = 40;
  world.longest_wavelength_m = 200;
  world.shortest_wavelength_m = 50;
  world.terrace_step_m = 8;
  world.terrace_steepness = 1;
  const Terrain layered(world);
  const auto scarps = layered.features({-200, -200, 200, 200});
  ASSERT_GT(scarps.size(), 50U);
  std::size_t on = 0;
  for (const PlantedFeature& feature : scarps) {
    ASSERT_EQ(feature.kind, FeatureKind::scarp);
    double low = 1e9;
    double high = -1e9;
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const double h = layered.height(feature.x + dx * feature.radius_m, feature.y + dy * feature.radius_m);
      low = std::min(low, h);
      high = std::max(high, h);
    }
    on += high - low > 3 ? 1U : 0U;
  }
  EXPECT_GT(on, 9 * scarps.size() / 10);
}

TEST(Landforms, BoulderFieldsHoldMoreRocksThanTheGroundAround) {
  WorldParams world = bare(0.2);
  world.rock_density = 0.05;
  world.boulder_field_density = 0.5;
  world.boulder_field_rock_density = 0.9;
  const auto features = Terrain(world).features({0, 0, 300, 300});
  double field_area = 0;
  int in_field = 0;
  int rocks = 0;
  for (const PlantedFeature& rock : features) {
    if (rock.kind == FeatureKind::boulder_field) field_area += 3.14159 * rock.radius_m * rock.radius_m;
    if (rock.kind != FeatureKind::rock) continue;
    ++rocks;
    in_field += std::any_of(features.begin(), features.end(),
                            [&](const PlantedFeature& field) {
                              return field.kind == FeatureKind::boulder_field &&
                                     std::hypot(rock.x - field.x, rock.y - field.y) < field.radius_m;
                            })
                    ? 1
                    : 0;
  }
  const double inside = in_field / field_area;
  const double outside = (rocks - in_field) / (300.0 * 300 - field_area);
  EXPECT_GT(rocks, 100);
  EXPECT_GT(inside, 10 * outside);
}

TEST(Landforms, OutcropsStandOutOfTheGroundByTheirRelief) {
  WorldParams world = bare(0.2);
  world.outcrop_density = 0.4;
  const Terrain terrain(world);
  const auto features = terrain.features({0, 0, 500, 500});
  EXPECT_GT(features.size(), 20U);
  for (const PlantedFeature& outcrop : features) {
    ASSERT_EQ(outcrop.kind, FeatureKind::outcrop);
    const double top = terrain.height(outcrop.x, outcrop.y);
    EXPECT_GT(top, 0.8 * outcrop.relief_m);
    EXPECT_LT(top, 1.2 * outcrop.relief_m);
    EXPECT_LE(top, terrain.highest());
  }
}

TEST(Landforms, LayersOfABoulderFieldAddBouldersWithinItOnly) {
  WorldParams world = bare(0.2);
  world.rock_density = 0.05;
  world.boulder_field_density = 0.5;
  const auto counted = [&](int layers) {
    world.boulder_field_layers = layers;
    const auto features = Terrain(world).features({0, 0, 300, 300});
    std::pair<int, int> inside_outside{0, 0};
    for (const PlantedFeature& rock : features) {
      if (rock.kind != FeatureKind::rock) continue;
      const bool inside = std::any_of(features.begin(), features.end(), [&](const PlantedFeature& field) {
        return field.kind == FeatureKind::boulder_field &&
               std::hypot(rock.x - field.x, rock.y - field.y) < field.radius_m;
      });
      ++(inside ? inside_outside.first : inside_outside.second);
    }
    return inside_outside;
  };
  const auto [one_inside, one_outside] = counted(1);
  const auto [three_inside, three_outside] = counted(3);
  EXPECT_NEAR(three_inside, 3 * one_inside, 0.3 * one_inside);
  EXPECT_EQ(three_outside, one_outside);
}

}  // namespace
}  // namespace ilp::world
