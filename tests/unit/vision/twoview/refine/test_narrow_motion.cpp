// Two views of a narrow field: the turn that perspective tells hardly, and the motion that turns the other way.
#include "fsw/vision/twoview/refine/narrow_motion.hpp"

#include <gtest/gtest.h>

#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/two_view.hpp"
#include "tests/unit/vision/multiview/narrow_body.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

using test::NarrowScene;

TwoViewWorkspace workspace;

struct NarrowPair {
  CameraModel camera;
  PointPairs pairs;
  RigidTransform b_from_a;  ///< truth, |t| = 1
};

NarrowPair make_pair(NarrowScene scene, double turn) {
  scene.keyframes = 2;
  scene.least_turn = scene.most_turn = turn;
  const test::SyntheticStrip strip = test::NarrowFlight(scene).strip();
  NarrowPair pair{.camera = strip.camera};
  const test::StripKeyframe& b = strip.keyframes[1];
  for (const Match& m : b.matches) {
    const Corner& a = strip.keyframes[0].corners[m.a];
    EXPECT_TRUE(pair.pairs.push_back({a.x, a.y, m.xb, m.yb, 0}));
  }
  pair.b_from_a = compose(b.truth, inverse(strip.keyframes[0].truth));
  pair.b_from_a.translation.normalize();
  return pair;
}

PairSelection select_all(const NormalisedPairs& pairs, PairIndices& indices) {
  indices.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_TRUE(indices.push_back(static_cast<std::uint16_t>(i)));
  return {indices.data(), indices.size()};
}

TwoViewResult estimate(const NarrowPair& pair) {
  TwoViewResult result;
  InlierMask inliers;
  EXPECT_TRUE(estimate_two_view(pair.pairs, pair.camera, pair.camera, {}, workspace, inliers, result).ok());
  return result;
}

bool points_the_wrong_way(const NarrowPair& pair, const TwoViewResult& result) {
  return pair.b_from_a.translation.dot(result.b_from_a.translation) < 0;
}

TEST(NarrowMotion, ATurnThatIsFarOffIsRefinedToTheTrueOne) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const NarrowPair pair = make_pair({.noise_px = 0, .wrong = 0, .seed = seed}, 0.2);
    normalise_pairs(pair.pairs, intrinsics_of(pair.camera), intrinsics_of(pair.camera), 1, workspace.pairs);
    PairIndices indices;
    const PairSelection all = select_all(workspace.pairs, indices);
    NarrowMotion motion;
    ASSERT_TRUE(narrow_motion(workspace.pairs, all, pair.b_from_a, motion));
    EXPECT_NEAR(std::fabs(motion.turn_rad), 0.2, 0.02) << "the axis is tilted a little from the image plane";
    for (const double factor : {0.2, 4.0}) {
      NarrowMotion start = motion;
      start.turn_rad *= factor;
      const RefinementParams params{RobustLoss::tukey, 2.34, 12, 1e-9};
      ASSERT_TRUE(refine_narrow_motion(workspace.pairs, all, params, start));
      // Corners are single precision.
      EXPECT_LT(test::rotation_error_deg(pose_of(start), pair.b_from_a), 0.05) << "seed " << seed << ", " << factor;
      EXPECT_LT(test::direction_error_deg(pose_of(start), pair.b_from_a), 0.05) << "seed " << seed << ", " << factor;
    }
  }
}

TEST(NarrowMotion, AWideFieldIsNoNarrowOne) {
  const test::Scene scene = test::make_scene({});
  normalise_pairs(scene.pairs, intrinsics_of(scene.camera_a), intrinsics_of(scene.camera_b), 1, workspace.pairs);
  PairIndices indices;
  NarrowMotion motion;
  EXPECT_FALSE(narrow_motion(workspace.pairs, select_all(workspace.pairs, indices), scene.b_from_a, motion));
}

TEST(NarrowMotion, ParallelRaysLeaveTwoMotions) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const TwoViewResult result = estimate(make_pair({.focal_px = 25000, .seed = seed}, 0.05));
    EXPECT_EQ(result.verdict, TwoViewVerdict::ill_conditioned) << name_of(result.verdict) << ", seed " << seed;
    EXPECT_FALSE(std::isfinite(result.sigma_direction_rad));
  }
}

TEST(NarrowMotion, TurnsThatPerspectiveTellsAreTold) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double turn : {0.1, 0.25, 0.45}) {
      const NarrowPair pair = make_pair({.seed = seed}, turn);
      const TwoViewResult result = estimate(pair);
      EXPECT_EQ(result.verdict, TwoViewVerdict::ok) << name_of(result.verdict) << ", seed " << seed << ", " << turn;
      EXPECT_FALSE(points_the_wrong_way(pair, result)) << "seed " << seed << ", " << turn;
    }
  }
}

TEST(NarrowMotion, TheWrongOneOfTwoMotionsHasLittleOdds) {
  int reported = 0;
  int wrong = 0;
  double largest = 0;
  for (const double radius : {60.0, 100.0, 200.0}) {
    for (const double turn : {0.03, 0.06, 0.12, 0.25, 0.4}) {
      for (const double noise : {0.1, 0.2, 0.4}) {
        for (unsigned seed = 1; seed <= 10; ++seed) {
          const NarrowScene scene{.radius_px = radius, .pointing_px = 40, .noise_px = noise, .seed = seed};
          const NarrowPair pair = make_pair(scene, turn);
          const TwoViewResult result = estimate(pair);
          reported += result.verdict == TwoViewVerdict::ok ? 1 : 0;
          const bool compared = std::isfinite(workspace.progress.rival_excess_px2);
          if (!compared || !points_the_wrong_way(pair, result)) continue;
          ++wrong;
          const double odds = workspace.progress.rival_excess_px2 / (2 * result.rms_px * result.rms_px);
          largest = std::max(largest, odds);
          EXPECT_NE(result.verdict, TwoViewVerdict::ok)
              << "seed " << seed << ", radius " << radius << ", turn " << turn << ", noise " << noise;
        }
      }
    }
  }
  std::printf("%d of 450 pairs told, %d wrong, with odds up to %.1f\n", reported, wrong, largest);
  EXPECT_GT(reported, 120);
  EXPECT_GT(wrong, 20) << "or else this tests nothing";
  EXPECT_LT(largest, 12);
}

}  // namespace
}  // namespace ilp
