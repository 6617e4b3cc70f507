// What the robust estimators are fast by: roots of a cubic, scoring that stops early, derivatives two at a time.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"
#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/robust/bail_out.hpp"
#include "fsw/vision/twoview/robust/model_score.hpp"
#include "fsw/vision/twoview/robust/msac.hpp"
#include "fsw/vision/twoview/solvers/cubic_roots.hpp"
#include "fsw/vision/twoview/solvers/decompose_essential.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

NormalisedPairs normalised;

/// scale (x - r0)(x - r1)(x - r2)
void expand(double scale, const double (&r)[3], double (&c)[4]) {
  c[3] = scale;
  c[2] = -scale * (r[0] + r[1] + r[2]);
  c[1] = scale * (r[0] * r[1] + r[0] * r[2] + r[1] * r[2]);
  c[0] = -scale * r[0] * r[1] * r[2];
}

TEST(CubicRoots, FindsWhatTheProductWasMadeOf) {
  Rng rng(3);
  for (int trial = 0; trial < 2000; ++trial) {
    double expected[3];
    for (double& root : expected) {
      root = test::symmetric(rng, 1);
      if (rng.uniform() < 0.3) root *= 1000;
    }
    std::sort(expected, expected + 3);
    const double gap = std::min(expected[1] - expected[0], expected[2] - expected[1]);
    if (gap < 1e-3) continue;
    double c[4];
    expand(test::symmetric(rng, 100), expected, c);
    double roots[3];
    ASSERT_EQ(cubic_roots(c, roots), 3) << expected[0] << " " << expected[1] << " " << expected[2];
    std::sort(roots, roots + 3);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(roots[i], expected[i], 1e-6 * std::max(1.0, std::fabs(expected[i])));
  }
}

TEST(CubicRoots, OneRealRootMultipleRootsAndLowerDegrees) {
  double roots[3];
  const double complex_pair[4] = {-8, 0, 0, 1};  // x^3 - 8
  ASSERT_EQ(cubic_roots(complex_pair, roots), 1);
  EXPECT_NEAR(roots[0], 2, 1e-14);
  const double triple[4] = {-1, 3, -3, 1};  // (x - 1)^3
  const int count = cubic_roots(triple, roots);
  ASSERT_GE(count, 1);
  for (int i = 0; i < count; ++i) EXPECT_NEAR(roots[i], 1, 1e-4);
  const double at_zero[4] = {0, 0, 0, 5};
  ASSERT_GE(cubic_roots(at_zero, roots), 1);
  EXPECT_EQ(roots[0], 0);
  const double square[4] = {2, -3, 1, 0};  // (x - 1)(x - 2)
  ASSERT_EQ(cubic_roots(square, roots), 2);
  EXPECT_NEAR(std::min(roots[0], roots[1]), 1, 1e-14);
  EXPECT_NEAR(std::max(roots[0], roots[1]), 2, 1e-14);
  const double line[4] = {-6, 3, 0, 0};
  ASSERT_EQ(cubic_roots(line, roots), 1);
  EXPECT_EQ(roots[0], 2);
}

TEST(CubicRoots, NoneForConstantsAndNonFinitePolynomials) {
  double roots[3];
  EXPECT_EQ(cubic_roots({0, 0, 0, 0}, roots), 0);
  EXPECT_EQ(cubic_roots({3, 0, 0, 0}, roots), 0);
  EXPECT_EQ(cubic_roots({1, std::numeric_limits<double>::quiet_NaN(), 1, 1}, roots), 0);
  EXPECT_EQ(cubic_roots({1, 1, 1, std::numeric_limits<double>::infinity()}, roots), 0);
}

TEST(AddBlock, IsTheSumOfBoundedErrorsWhateverTheCount) {
  for (std::size_t count = 1; count <= score_block; ++count) {
    float squared[score_block];
    double cost = 0;
    std::uint32_t inliers = 0;
    for (std::size_t i = 0; i < score_block; ++i) {
      squared[i] = 0.25F * static_cast<float>(i % 9);
      if (i % 7 == 6) squared[i] = std::numeric_limits<float>::quiet_NaN();
      if (i >= count) continue;
      const bool inlier = squared[i] < 1.5F;
      cost += inlier ? static_cast<double>(squared[i]) : 1.5;
      inliers += inlier ? 1 : 0;
    }
    RansacScore score{10, 5};
    add_block(squared, count, 1.5F, score);
    EXPECT_EQ(score.cost, 10 + cost) << count;
    EXPECT_EQ(score.inliers, 5 + inliers) << count;
  }
}

/// Matches seen before a model of `share` inliers, which cost nothing, is abandoned; all where it is not.
std::size_t seen_before_giving_up(double share, const BailOut& abandoned, std::size_t total, Rng& rng) {
  double cost = 0;
  for (std::size_t seen = 1; seen <= total; ++seen) {
    cost += rng.uniform() < share ? 0 : 1;
    if (seen % score_block == 0 && abandoned(cost, seen)) return seen;
  }
  return total;
}

TEST(BailOutTest, KeepsWhatEqualsTheBestAndGivesUpTheRestEarly) {
  constexpr std::size_t total = 500;
  constexpr int trials = 5000;
  Rng rng(11);
  for (const double best_share : {0.3, 0.5, 0.7}) {
    const BailOut abandoned({(1 - best_share) * total, sample_deviations}, 1, total);
    int lost = 0;
    double seen = 0;
    for (int trial = 0; trial < trials; ++trial) {
      // Better by two standard deviations, so that it does beat the best whatever the draw.
      const double better = best_share + 2 * std::sqrt(best_share * (1 - best_share) / total);
      lost += seen_before_giving_up(better, abandoned, total, rng) < total ? 1 : 0;
      seen += static_cast<double>(seen_before_giving_up(0.1, abandoned, total, rng));
    }
    EXPECT_LT(lost, trials / 100) << best_share;
    EXPECT_LT(seen / trials, best_share > 0.4 ? 60 : 150) << best_share;
  }
}

TEST(BailOutTest, WithoutDeviationsOnlyTheCostCounts) {
  const BailOut exact({100}, 1, 500);
  EXPECT_FALSE(exact(99, 100));
  EXPECT_TRUE(exact(100, 101));
  EXPECT_TRUE(exact(std::numeric_limits<double>::quiet_NaN(), 101));
}

double least_squares_cost(const RigidTransform& pose) {
  const Mat3 essential = essential_from_pose(pose);
  double sum = 0;
  for (const NormalisedPair& pair : normalised.exact) sum += sampson_squared(essential, pair, normalised.scale);
  return sum;
}

TEST(RefineRelativePose, EndsWhereNoStepLowersTheCost) {
  for (const int matches : {40, 41}) {
    test::SceneOptions options{.matches = matches, .noise_px = 0.5};
    const test::Scene scene = test::make_scene(options);
    normalise_pairs(scene.pairs, intrinsics_of(scene.camera_a), intrinsics_of(scene.camera_b), 1, normalised);
    std::vector<std::uint16_t> all(normalised.size());
    std::iota(all.begin(), all.end(), std::uint16_t{0});
    RigidTransform pose = scene.b_from_a;
    ASSERT_TRUE(
        refine_relative_pose(normalised, {all.data(), all.size()}, {RobustLoss::truncated, 1e3, 50, 1e-15}, pose));
    const double cost = least_squares_cost(pose);
    EXPECT_LT(cost, least_squares_cost(scene.b_from_a));
    for (int axis = 0; axis < 3; ++axis) {
      for (const double step : {-1e-5, 1e-5}) {
        RigidTransform turned = pose;
        turned.rotation = turned.rotation * rotation_from_vector(step * Vec3::Unit(axis));
        EXPECT_GT(least_squares_cost(turned), cost) << matches;
        RigidTransform shifted = pose;
        shifted.translation = (shifted.translation + 10 * step * Vec3::Unit(axis)).normalized();
        EXPECT_GE(least_squares_cost(shifted), cost) << matches;
      }
    }
  }
}

}  // namespace
}  // namespace ilp
