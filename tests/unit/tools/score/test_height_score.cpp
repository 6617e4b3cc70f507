// Merged heights: errors come out where they were put in, whatever the strip's world is.

#include "sim/tools/score/height_score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/ground/map/strip_map.hpp"
#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

using test::StripScene;

HeightScore score_of(const StripScene& scene, const world::HeightGrid& truth) {
  const intake::Strip& strip = scene.flight.strips.at(1);
  const auto aligned = align_strip(scene.flight, strip, scene.truth, StripScene::flying_height);
  const auto grid = map::build_grid(scene.flight, strip, {});
  std::vector<Vec3> centres;
  for (const double x : scene.x) centres.emplace_back(x, 0, StripScene::flying_height);
  return score_heights(*grid, *aligned, truth, centres, StripScene::flying_height);
}

TEST(HeightScore, BowOfTheGroundShowsInTheProfile) {
  StripScene scene;
  const auto bow = [](double x) { return 2 * (1 - (x - 60) * (x - 60) / 14400); };  // m, highest in the middle
  scene.distort([&](std::size_t k, int column, int) { return 1 - bow(scene.ground_x(k, column)) / 100; });
  const HeightScore score = score_of(scene, StripScene::true_heights());
  ASSERT_GT(score.profile.size(), 20U);
  std::size_t cells = 0;
  for (const HeightProfilePoint& point : score.profile) {
    cells += point.cells;
    if (point.cells < 100) continue;
    EXPECT_NEAR(point.error, bow(point.distance), 0.08) << point.distance;
  }
  EXPECT_EQ(cells, score.error.count);
  EXPECT_GT(score.error.p95, 1.9);
  EXPECT_LT(score.error.p95, 2.01);
}

TEST(HeightScore, IsThatOfThePlaceAndNotOfThePixel) {
  // True ground rises by 5 % along x; the products say that it is level at z = 0.
  world::HeightGrid truth = StripScene::true_heights();
  for (int j = 0; j < truth.height_m.height; ++j) {
    for (int i = 0; i < truth.height_m.width; ++i) {
      truth.height_m.at(i, j) = static_cast<float>(0.05 * (truth.x0 + i * truth.cell));
    }
  }
  const StripScene scene;
  const HeightScore score = score_of(scene, truth);
  for (const HeightProfilePoint& point : score.profile) {
    if (point.cells < 100) continue;
    EXPECT_NEAR(point.error, -0.05 * point.distance, 0.15) << point.distance;
  }
  // The map lies on the grid of the truth.
  ASSERT_TRUE(score.error_map.same_size(truth.height_m.width, truth.height_m.height));
  int compared = 0, exact = 0;
  for (int j = 0; j < score.error_map.height; ++j) {
    for (int i = 0; i < score.error_map.width; ++i) {
      const float error = score.error_map.at(i, j);
      if (!std::isfinite(error)) continue;
      const double expected = -0.05 * (truth.x0 + i * truth.cell);
      ASSERT_NEAR(error, expected, 0.5);  // edges of merged pieces take the nearest pixel's height
      exact += std::fabs(error - expected) < 0.002 ? 1 : 0;
      ++compared;
    }
  }
  EXPECT_GT(exact, compared * 9 / 10);
  EXPECT_NEAR(compared, 220 * 120, 0.05 * 220 * 120);
}

TEST(HeightScore, GroundWithoutTruthIsNotCompared) {
  world::HeightGrid truth = StripScene::true_heights();
  for (int j = 0; j < truth.height_m.height; ++j) {
    for (int i = 0; i < truth.height_m.width; ++i) {
      if (truth.x0 + i > 60) truth.height_m.at(i, j) = std::numeric_limits<float>::infinity();
    }
  }
  const HeightScore score = score_of(StripScene(), truth);
  // The strip covers x from -50 to 170.
  EXPECT_NEAR(static_cast<double>(score.error.count) / static_cast<double>(score.covered), 110.0 / 220, 0.02);
  EXPECT_NEAR(score.error.p95, 0, 1e-3);
}

}  // namespace
}  // namespace ilp::score
