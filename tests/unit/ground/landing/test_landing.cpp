// Hazards of a footprint on ground whose shape is known, their probabilities, and the sites that follow.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "sim/ground/landing/landing_safety.hpp"
#include "tests/support/said.hpp"

namespace ilp::landing {
namespace {

constexpr double cell = 0.2;
constexpr std::int32_t side = 200;

/// `height(x, y)` on a grid of 40 m, every height with the error `sigma`.
template <typename Height>
map::GroundGrid ground(Height height, float sigma = 0.01F) {
  map::GroundGrid grid(0, (side - 1) * cell, cell, side, side);
  for (std::int32_t row = 0; row < side; ++row) {
    for (std::int32_t column = 0; column < side; ++column) {
      grid.height.at(column, row) = static_cast<float>(height(column * cell, (side - 1 - row) * cell));
      grid.sigma.at(column, row) = sigma;
    }
  }
  return grid;
}

double half_sphere(double x, double y, double at_x, double at_y, double radius) {
  const double left = radius * radius - (x - at_x) * (x - at_x) - (y - at_y) * (y - at_y);
  return left > 0 ? std::sqrt(left) : 0;
}

TEST(FootprintHazards, OfAPlaneAreItsSlopeAndNothingElse) {
  const auto hazards = footprint_hazards(ground([](double x, double y) { return 100 + 0.1 * x - 0.2 * y; }), {5, 1});
  const std::size_t middle = hazards.step_m.index(hazards.geometry.columns / 2, hazards.geometry.rows / 2);
  EXPECT_NEAR(hazards.gradient_x.samples[middle], 0.1, 1e-4);
  EXPECT_NEAR(hazards.gradient_y.samples[middle], -0.2, 1e-4);
  EXPECT_LT(hazards.step_m.samples[middle], 1e-4);
  EXPECT_LT(hazards.roughness_m.samples[middle], 1e-4);
}

TEST(FootprintHazards, AreInMetresOnAStripInOtherUnits) {
  const auto plane = [](double x, double y) { return 0.1 * x + half_sphere(x, y, 20, 20, 1); };
  const auto metres = footprint_hazards(ground(plane), {5, 1}), units = footprint_hazards(ground(plane), {10, 2});
  const std::size_t middle = metres.step_m.index(metres.geometry.columns / 2, metres.geometry.rows / 2);
  EXPECT_NEAR(units.gradient_x.samples[middle], metres.gradient_x.samples[middle], 1e-6);
  EXPECT_NEAR(units.step_m.samples[middle], 2 * metres.step_m.samples[middle], 1e-5);
  EXPECT_NEAR(units.sigma_m.samples[middle], 0.02, 1e-6);
}

TEST(FootprintHazards, ARockIsAStepOfItsHeightWhereverTheFootprintMeetsIt) {
  const auto hazards =
      footprint_hazards(ground([](double x, double y) { return half_sphere(x, y, 20, 20, 0.7); }), {6, 1});
  for (std::int32_t row = 0; row < hazards.geometry.rows; ++row) {
    for (std::int32_t column = 0; column < hazards.geometry.columns; ++column) {
      const double x = hazards.geometry.x0 + column * hazards.geometry.cell - 20,
                   y = hazards.geometry.y0 - row * hazards.geometry.cell - 20, away = std::sqrt(x * x + y * y);
      const float step = hazards.step_m.at(column, row);
      if (!std::isfinite(step)) continue;
      if (away < 2) {
        EXPECT_NEAR(step, 0.7, 0.25) << x << " " << y;
      } else if (away > 3.9) {
        EXPECT_LT(step, 1e-4) << x << " " << y;
      }
    }
  }
}

TEST(FootprintHazards, TheStatedErrorOfTheSlopeIsThatOfNoiseAsWideAsMatchingMakesIt) {
  // Patches of 6 x 6 cells have one error, about as many cells as an error of matching spreads over.
  constexpr double sigma = 0.1;
  double squares = 0;
  int count = 0;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int flight = 0; flight < 20; ++flight) {
    std::vector<double> patches((side / 6 + 1) * (side / 6 + 1));
    for (double& patch : patches) patch = sigma * normal(random);
    const auto grid = ground(
        [&](double x, double y) {
          const auto column = static_cast<std::size_t>(x / cell + 0.5), row = static_cast<std::size_t>(y / cell + 0.5);
          return patches[row / 6 * (side / 6 + 1) + column / 6];
        },
        static_cast<float>(sigma));
    const auto hazards = footprint_hazards(grid, {8, 1});
    for (std::int32_t row = 20; row < hazards.geometry.rows - 20; row += 15) {
      for (std::int32_t column = 20; column < hazards.geometry.columns - 20; column += 15) {
        const std::size_t i = hazards.step_m.index(column, row);
        if (!std::isfinite(hazards.step_m.samples[i])) continue;
        const double s = hazards.gradient_sigma.samples[i];
        squares += std::pow(hazards.gradient_x.samples[i] / s, 2) + std::pow(hazards.gradient_y.samples[i] / s, 2);
        count += 2;
      }
    }
  }
  ASSERT_GT(count, 200);
  EXPECT_NEAR(std::sqrt(squares / count), 1, 0.3);
}

TEST(FootprintHazards, GroundThatWasNotSeenIsNotSafe) {
  auto grid = ground([](double, double) { return 0; });
  for (std::int32_t row = 90; row < 110; ++row) {
    for (std::int32_t column = 90; column < 110; ++column) {
      grid.height.at(column, row) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  const LandingMap map = assess_landing(grid, 1, 0.001, {6, 10 * degree, 1.2});
  EXPECT_TRUE(std::isnan(map.safe.at(map.safe.width / 2, map.safe.height / 2)));
  EXPECT_TRUE(std::isnan(map.safe.at(0, 0))) << "a footprint that leaves the map";
  ASSERT_EQ(map.sites.size(), most_sites);
  for (const LandingSite& site : map.sites) {
    EXPECT_GT(std::max(std::abs(site.x - 20), std::abs(site.y - 20)), 2) << "in the hole";
  }
}

TEST(LandingProbability, OfLevelGroundIsThatOfRayleigh) {
  for (const double sigma : {0.02, 0.05, 0.1}) {
    const double limit = std::tan(8 * degree);
    EXPECT_NEAR(steep_probability(0, sigma, limit), std::exp(-limit * limit / (2 * sigma * sigma)), 5e-4);
  }
}

TEST(LandingProbability, OfASlopeIsTheShareOfDrawsThatAreSteeper) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double gradient : {0.05, 0.12, 0.16, 0.25}) {
    const double sigma = 0.04, limit = std::tan(8 * degree);
    int steep = 0;
    constexpr int draws = 40000;
    for (int k = 0; k < draws; ++k) {
      const double x = 0.6 * gradient + sigma * normal(random), y = 0.8 * gradient + sigma * normal(random);
      steep += x * x + y * y > limit * limit ? 1 : 0;
    }
    EXPECT_NEAR(steep_probability(gradient, sigma, limit), static_cast<double>(steep) / draws, 0.01);
  }
}

TEST(LandingProbability, OfAStepFallsWithTheStepAndWithItsError) {
  EXPECT_LT(uneven_probability(0.3, 0.1, 1, 30), 0.001);
  EXPECT_NEAR(uneven_probability(1, 0.1, 1, 30), 0.7, 0.15) << "what stands out is measured too low";
  EXPECT_GT(uneven_probability(2, 0.1, 1, 30), 0.99);
  EXPECT_LT(uneven_probability(0.3, 0.1, 0.25, 30), 0.5) << "most of this step is noise";
  EXPECT_GT(uneven_probability(0.6, 0.3, 1, 30), uneven_probability(0.6, 0.01, 1, 30));
  EXPECT_GT(uneven_probability(0.6, 0.05, 1, 15), uneven_probability(0.6, 0.05, 1, 60)) << "a coarser map shows less";
}

TEST(LandingSites, AreApartRankedAndAwayFromRocksAndSlopes) {
  // Steep for x > 25, a rock of 1.5 m in the middle of the rest.
  const auto grid =
      ground([](double x, double y) { return (x > 25 ? 0.4 * (x - 25) : 0) + half_sphere(x, y, 12, 20, 1.5); }, 0.02F);
  const LandingMap map = assess_landing(grid, 1, 0.002, {5, 8 * degree, 1.2});
  ASSERT_GE(map.sites.size(), 5U);
  for (std::size_t i = 0; i < map.sites.size(); ++i) {
    const LandingSite& site = map.sites[i];
    EXPECT_GE(site.safe, least_safe);
    EXPECT_LT(site.x, 25.5);
    EXPECT_GT(std::hypot(site.x - 12, site.y - 20), 2.5 + 1);
    EXPECT_LE(site.safe, i > 0 ? map.sites[i - 1].safe : 1);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE(std::hypot(site.x - map.sites[j].x, site.y - map.sites[j].y), 5 - 1e-9);
    }
  }
}

TEST(LandingSites, LeaveRoomForARockThatMatchingMayMiss) {
  const auto waves = ground([](double x, double) { return 0.25 * std::sin(x * 1.6); });
  const auto with_step = [&](double step_m) { return assess_landing(waves, 1, 0.002, {8, 10 * degree, step_m}); };
  // Waves of 0.5 m and a rock of four cells, which are 0.8 m.
  const LandingMap narrow = with_step(1.25);
  EXPECT_GT(narrow.safe.at(narrow.safe.width / 2, narrow.safe.height / 2), least_safe) << "probable enough";
  EXPECT_TRUE(narrow.sites.empty());
  EXPECT_FALSE(with_step(1.35).sites.empty());
}

TEST(LandingSites, AreNotToldWhereWhatIsUpIsHardlyKnown) {
  const auto flat = ground([](double, double) { return 0; });
  EXPECT_FALSE(assess_landing(flat, 1, 0.002, {5, 8 * degree, 1.2}).sites.empty());
  EXPECT_TRUE(assess_landing(flat, 1, 0.1, {5, 8 * degree, 1.2}).sites.empty());
}

TEST(LandingLimits, AreReadAndRefusedWithTheirRanges) {
  const LandingLimits given = read_landing_limits("6,8.5,0.9"), usual = read_landing_limits("5");
  EXPECT_DOUBLE_EQ(given.footprint_m, 6);
  EXPECT_NEAR(given.slope_rad, 8.5 * degree, 1e-12);
  EXPECT_DOUBLE_EQ(given.step_m, 0.9);
  EXPECT_NEAR(usual.slope_rad, 10 * degree, 1e-12);
  EXPECT_DOUBLE_EQ(usual.step_m, 0.5);
  const auto refused = [](const std::string& text) { return test::error_of([&] { (void)read_landing_limits(text); }); };
  EXPECT_NE(refused("6,8").find("FOOTPRINT_M,SLOPE_DEG,STEP_M"), std::string::npos);
  EXPECT_NE(refused("6,80,1").find("from 0.100 to 60.0 degrees"), std::string::npos) << refused("6,80,1");
  EXPECT_NE(refused("nan,8,1").find("the footprint 'nan'"), std::string::npos);
  EXPECT_NE(refused("6m").find("'6m'"), std::string::npos);
}

TEST(LandingLimits, ThatTheMapCannotShowAreRefusedWithTheLeastOnes) {
  const auto flat = ground([](double, double) { return 0; });
  const auto refused = [&](const LandingLimits& limits) {
    return test::error_of([&] { (void)assess_landing(flat, 1, 0.002, limits); });
  };
  EXPECT_NE(refused({0.5, 8 * degree, 1.2}).find("name 1.00 m or more"), std::string::npos);
  EXPECT_NE(refused({5, 8 * degree, 1.1}).find("name 1.20 m or more"), std::string::npos);
  EXPECT_NE(refused({60, 8 * degree, 2}).find("no footprint of 60.0 m is covered"), std::string::npos);
}

}  // namespace
}  // namespace ilp::landing
