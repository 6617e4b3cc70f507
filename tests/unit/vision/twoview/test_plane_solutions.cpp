// The two poses that a plane leaves: when visibility alone tells them apart, and that a third view does.
#include <gtest/gtest.h>

#include <limits>

#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/third_view.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

TwoViewWorkspace workspace;
InlierMask inliers;

const CameraModel camera = test::make_camera(700, 690, 321, 238);

/// Ground plane.X = 1 in frame a, and the camera at `centre`, turned by `turn`.
struct View {
  RigidTransform b_from_a;
  PointPairs pairs;
};

struct ViewOptions {
  Vec3 centre;
  Vec3 turn = Vec3(0.02, -0.03, 0.05);
  Vec3 plane = Vec3(0, 0, 1);
  double noise_px = 0.3;
  double outlier_share = 0;
  std::size_t matches = 300;
  std::uint64_t seed = 1;
};

View make_view(const ViewOptions& options) {
  Rng rng(options.seed, 9);
  View view;
  view.b_from_a.rotation = rotation_from_vector(options.turn);
  view.b_from_a.translation = -(view.b_from_a.rotation * options.centre);
  while (view.pairs.size() < options.matches) {
    const double ua = rng.uniform() * camera.width;
    const double va = rng.uniform() * camera.height;
    const Vec3 ray((ua - camera.cx) / camera.fx, (va - camera.cy) / camera.fy, 1);
    const Vec3 seen = view.b_from_a * (ray / options.plane.dot(ray));
    double ub = camera.fx * seen.x() / seen.z() + camera.cx;
    double vb = camera.fy * seen.y() / seen.z() + camera.cy;
    if (seen.z() < 0.05 || ub < 0 || vb < 0 || ub >= camera.width || vb >= camera.height) continue;
    if (rng.uniform() < options.outlier_share) {
      ub = rng.uniform() * camera.width;
      vb = rng.uniform() * camera.height;
    }
    const double noise[4] = {test::gaussian(rng), test::gaussian(rng), test::gaussian(rng), test::gaussian(rng)};
    static_cast<void>(view.pairs.push_back({ua + options.noise_px * noise[0], va + options.noise_px * noise[1],
                                            ub + options.noise_px * noise[2], vb + options.noise_px * noise[3], 0}));
  }
  return view;
}

TwoViewResult estimate(const View& view, std::uint64_t seed = 1) {
  RansacParams params{.seed = seed};
  TwoViewResult result;
  EXPECT_TRUE(estimate_two_view(view.pairs, camera, camera, params, workspace, inliers, result).ok());
  return result;
}

ThirdViewChoice choose(const PlaneSolutions& solutions, const View& third) {
  ThirdViewChoice choice;
  EXPECT_TRUE(choose_by_third_view(solutions, third.pairs, camera, camera, {}, workspace, choice).ok());
  return choice;
}

/// Climbs or descends obliquely: both normals look towards the camera.
ViewOptions oblique(std::uint64_t seed) {
  Rng rng(seed, 10);
  ViewOptions options;
  options.centre = Vec3(0.15 + 0.05 * rng.uniform(), test::symmetric(rng, 0.05), seed % 2 == 0 ? 0.2 : -0.2);
  options.plane = Vec3(test::symmetric(rng, 0.15), test::symmetric(rng, 0.15), 1);
  options.seed = seed;
  return options;
}

bool is_the_motion(const PlaneSolution& solution, const RigidTransform& truth) {
  return test::rotation_error_deg(solution.motion.b_from_a, truth) < 2 &&
         test::direction_error_deg(solution.motion.b_from_a, truth) < 6;
}

TEST(PlaneSolutions, ObliqueMotionLeavesTwoOneOfWhichIsTrue) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const View view = make_view(oblique(seed));
    const TwoViewResult result = estimate(view);
    EXPECT_EQ(result.verdict, TwoViewVerdict::planar);
    ASSERT_EQ(result.planes.count, 2U) << seed;
    const PlaneSolution* const solution = result.planes.solution;
    EXPECT_NE(is_the_motion(solution[0], view.b_from_a), is_the_motion(solution[1], view.b_from_a)) << seed;
    // The pose that was returned is one of them, the first.
    EXPECT_TRUE(is_the_motion(solution[0], result.b_from_a)) << seed;
    for (int k = 0; k < 2; ++k) {
      EXPECT_GT(solution[k].support, 0.8 * result.inliers);  // two errors a match, with one threshold
      EXPECT_LE(solution[k].support, result.inliers);
    }
  }
}

TEST(PlaneSolutions, VisibilityRefutesTheRivalOfLevelFlight) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ViewOptions options{.centre = Vec3(0.18, 0.002 * static_cast<double>(seed), 0), .seed = seed};
    const View view = make_view(options);
    const TwoViewResult result = estimate(view);
    ASSERT_EQ(result.planes.count, 1U) << seed;
    const PlaneSolution& only = result.planes.solution[0];
    EXPECT_TRUE(is_the_motion(only, view.b_from_a)) << seed;
    // The plane at one altitude, in baselines.
    EXPECT_LT((only.motion.plane / options.centre.norm() - options.plane).norm(), 0.1) << seed;
  }
}

TEST(PlaneSolutions, NoneWhereReliefOrRotationExplainsThePair) {
  ViewOptions options{.centre = Vec3::Zero()};
  EXPECT_EQ(estimate(make_view(options)).planes.count, 0U);
  test::SceneOptions relief;
  const test::Scene scene = test::make_scene(relief);
  TwoViewResult result;
  ASSERT_TRUE(estimate_two_view(scene.pairs, scene.camera_a, scene.camera_b, {}, workspace, inliers, result).ok());
  EXPECT_EQ(result.verdict, TwoViewVerdict::ok);
  EXPECT_EQ(result.planes.count, 0U);
}

TEST(ThirdView, TellsTheTrueMotion) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ViewOptions options = oblique(seed);
    const View second = make_view(options);
    const PlaneSolutions solutions = estimate(second).planes;
    ASSERT_EQ(solutions.count, 2U) << seed;
    ViewOptions third = options;
    third.centre = Vec3(0.1, 0.2, 0.05);
    third.turn = Vec3(-0.04, 0.02, -0.1);
    third.seed = seed + 100;
    third.outlier_share = 0.3;
    const ThirdViewChoice choice = choose(solutions, make_view(third));
    ASSERT_TRUE(choice.decided) << seed << ": " << choice.excess_px2[0] << " " << choice.excess_px2[1];
    EXPECT_TRUE(is_the_motion(solutions.solution[choice.chosen], second.b_from_a)) << seed;
    EXPECT_FALSE(is_the_motion(solutions.solution[1 - choice.chosen], second.b_from_a)) << seed;
    EXPECT_GT(choice.matches, 180U);

    // The order of the solutions does not matter.
    PlaneSolutions swapped = solutions;
    std::swap(swapped.solution[0], swapped.solution[1]);
    EXPECT_EQ(choose(swapped, make_view(third)).chosen, 1 - choice.chosen);
  }
}

TEST(ThirdView, TellsOnTheLineOfTheOthersToo) {
  // The false plane depends on how far along the line the second camera went.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ViewOptions options = oblique(seed);
    const View second = make_view(options);
    const PlaneSolutions solutions = estimate(second).planes;
    ASSERT_EQ(solutions.count, 2U);
    ViewOptions third = options;
    third.centre = 1.8 * options.centre;
    third.seed = seed + 100;
    const ThirdViewChoice choice = choose(solutions, make_view(third));
    ASSERT_TRUE(choice.decided) << seed;
    EXPECT_TRUE(is_the_motion(solutions.solution[choice.chosen], second.b_from_a)) << seed;
  }
}

TEST(ThirdView, FromTheSamePlaceLeavesItOpen) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ViewOptions options = oblique(seed);
    const PlaneSolutions solutions = estimate(make_view(options)).planes;
    ASSERT_EQ(solutions.count, 2U);
    ViewOptions third = options;
    third.turn = Vec3(-0.04, 0.02, -0.1);
    third.seed = seed + 100;
    EXPECT_FALSE(choose(solutions, make_view(third)).decided) << seed;
    third.centre = Vec3::Zero();
    EXPECT_FALSE(choose(solutions, make_view(third)).decided) << seed;
  }
}

TEST(ThirdView, OtherGroundDecidesNothing) {
  // The matches of the third view are on a plane that neither solution knows.
  const ViewOptions options = oblique(3);
  const PlaneSolutions solutions = estimate(make_view(options)).planes;
  ViewOptions third = options;
  third.centre = Vec3(0.1, 0.2, 0.05);
  third.plane = Vec3(0.3, -0.6, 1);
  EXPECT_FALSE(choose(solutions, make_view(third)).decided);
}

TEST(ThirdView, NothingToTellOrNothingToTellItBy) {
  const ViewOptions options = oblique(1);
  PlaneSolutions solutions = estimate(make_view(options)).planes;
  ASSERT_EQ(solutions.count, 2U);
  ViewOptions third = options;
  third.centre = Vec3(0.1, 0.2, 0.05);
  for (const std::size_t matches : {0U, 3U, 7U, 19U}) {
    third.matches = matches;
    EXPECT_FALSE(choose(solutions, make_view(third)).decided) << matches;
  }
  third.matches = 100;
  View nonsense = make_view(third);
  for (PointPair& pair : nonsense.pairs) pair.xb = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(choose(solutions, nonsense).decided);

  solutions.count = 1;
  EXPECT_FALSE(choose(solutions, make_view(third)).decided);
  RansacParams params{.threshold_px = 0};
  ThirdViewChoice choice;
  EXPECT_FALSE(choose_by_third_view(solutions, make_view(third).pairs, camera, camera, params, workspace, choice).ok());
}

}  // namespace
}  // namespace ilp
