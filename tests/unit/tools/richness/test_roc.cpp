#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/rng.hpp"
#include "sim/tools/richness/roc.hpp"

namespace ilp::richness {
namespace {

TEST(Roc, AreaIsTheShareOfPairsInTheRightOrder) {
  // By hand: of the 2 x 3 pairs, 0.9 wins 3, 0.5 wins 1 and ties 1.
  const std::vector<ScoredImage> images = {
      {0.9, true, 0}, {0.5, true, 1}, {0.6, false, 0}, {0.5, false, 1}, {0.1, false, 2}};
  EXPECT_DOUBLE_EQ(area_under_roc(images, 0).value, 4.5 / 6);
  EXPECT_EQ(area_under_roc(images, 0).interesting, 2U);
  EXPECT_TRUE(std::isnan(area_under_roc({{0.9, true, 0}}, 0).value));
}

TEST(Roc, AreaUnderTheCurveIsTheArea) {
  Rng rng(5);
  std::vector<ScoredImage> images;
  for (int i = 0; i < 500; ++i) {
    const bool interesting = rng.uniform() < 0.3;
    images.push_back({std::floor(20 * (rng.uniform() + (interesting ? 0.3 : 0))), interesting, 0});
  }
  double area = 0;
  const auto curve = roc_curve(images);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    area += (curve[i].first - curve[i - 1].first) * 0.5 * (curve[i].second + curve[i - 1].second);
  }
  EXPECT_NEAR(area, area_under_roc(images, 0).value, 1e-12);
}

// Two normal distributions one deviation apart: the area is Phi(1 / sqrt 2) = 0.7602.
TEST(Roc, IntervalHoldsTheTruthAndNarrowsWithTheNumberOfWorlds) {
  const auto sample = [](int worlds) {
    Rng rng(9);
    const auto normal = [&] {
      double sum = -6;
      for (int k = 0; k < 12; ++k) sum += rng.uniform();
      return sum;
    };
    std::vector<ScoredImage> images;
    for (int w = 0; w < worlds; ++w) {
      for (int i = 0; i < 8; ++i) images.push_back({normal() + (i % 2 != 0 ? 1 : 0), i % 2 != 0, std::size_t(w)});
    }
    return area_under_roc(images, 400);
  };
  const Auc few = sample(25);
  const Auc many = sample(400);
  EXPECT_LT(many.low, 0.7602);
  EXPECT_GT(many.high, 0.7602);
  EXPECT_LT(few.low, 0.7602);
  EXPECT_GT(few.high, 0.7602);
  EXPECT_NEAR((few.high - few.low) / (many.high - many.low), 4, 1.5);
}

TEST(Roc, RankCorrelationSeesOrderOnly) {
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {1, 10, 100, 1000}), 1);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {5, 4, 3, 2}), -1);
  // Spearman with a tie, by hand: ranks 0, 1.5, 1.5, 3 against 0, 1, 2, 3.
  EXPECT_NEAR(rank_correlation({1, 2, 2, 3}, {1, 2, 3, 4}), 4.5 / std::sqrt(4.5 * 5), 1e-12);
}

}  // namespace
}  // namespace ilp::richness
