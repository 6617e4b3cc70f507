// Triangulation against points placed by hand and against an exhaustive search of the reprojection error.
#include "fsw/vision/twoview/solvers/triangulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fsw/base/rng.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

RayView see(const RigidTransform& cam_from_world, const Vec3& point) {
  const Vec3 p = cam_from_world * point;
  return {p.head<2>() / p.z(), cam_from_world};
}

RigidTransform camera_at(const Vec3& centre, const Vec3& turn) {
  const Mat3 rotation = rotation_from_vector(turn);
  return {rotation, -(rotation * centre)};
}

double cost_of(const RayView* views, std::size_t count, const Vec3& x) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = views[i].cam_from_world * x;
    sum += (p.head<2>() / p.z() - views[i].normalised).squaredNorm();
  }
  return sum;
}

TEST(Triangulate, ExactRaysMeetInThePoint) {
  Rng rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 point(test::symmetric(rng, 2), test::symmetric(rng, 2), 5 + test::symmetric(rng, 2));
    RayView views[4];
    for (int i = 0; i < 4; ++i) {
      const Vec3 turn(test::symmetric(rng, 0.1), test::symmetric(rng, 0.1), test::symmetric(rng, 1));
      views[i] = see(camera_at(Vec3(0.7 * i, test::symmetric(rng, 0.3), test::symmetric(rng, 0.3)), turn), point);
    }
    for (const std::size_t count : {std::size_t{2}, std::size_t{4}}) {
      TriangulatedPoint result;
      ASSERT_TRUE(triangulate(views, count, result).ok());
      EXPECT_LT((result.position - point).norm(), 1e-9);
      EXPECT_TRUE(result.in_front);
      EXPECT_LT(result.max_error, 1e-10);
    }
  }
}

TEST(Triangulate, AngleIsTheAngleBetweenTheRays) {
  const RayView views[2] = {see(camera_at(Vec3(-1, 0, 0), Vec3::Zero()), Vec3(0, 0, 1)),
                            see(camera_at(Vec3(1, 0, 0), Vec3::Zero()), Vec3(0, 0, 1))};
  TriangulatedPoint result;
  ASSERT_TRUE(triangulate(views, 2, result).ok());
  EXPECT_NEAR(result.angle_rad, 3.14159265358979 / 2, 1e-12);
}

TEST(Triangulate, MinimisesTheReprojectionError) {
  Rng rng(11);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 point(test::symmetric(rng, 1), test::symmetric(rng, 1), 4);
    RayView views[3];
    for (int i = 0; i < 3; ++i) {
      views[i] = see(camera_at(Vec3(0.5 * i, 0, 0), Vec3(0, 0.02 * i, 0)), point);
      views[i].normalised += Vec2(test::symmetric(rng, 2e-3), test::symmetric(rng, 2e-3));
    }
    TriangulatedPoint result;
    ASSERT_TRUE(triangulate(views, 3, result).ok());
    const double best = cost_of(views, 3, result.position);
    double largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max(largest, std::sqrt(cost_of(views + i, 1, result.position)));
    EXPECT_NEAR(result.max_error, largest, 1e-15);
    // No neighbour in space is better, near or far.
    for (int probe = 0; probe < 200; ++probe) {
      const double reach = probe % 2 == 0 ? 1e-4 : 1e-2;
      const Vec3 other =
          result.position + Vec3(test::symmetric(rng, reach), test::symmetric(rng, reach), test::symmetric(rng, reach));
      EXPECT_GE(cost_of(views, 3, other), best * (1 - 1e-9));
    }
  }
}

TEST(Triangulate, BehindACameraIsSaid) {
  // Rays that diverge in front meet behind.
  const RayView views[2] = {{Vec2(-0.1, 0), camera_at(Vec3(-1, 0, 0), Vec3::Zero())},
                            {Vec2(0.1, 0), camera_at(Vec3(1, 0, 0), Vec3::Zero())}};
  TriangulatedPoint result;
  ASSERT_TRUE(triangulate(views, 2, result).ok());
  EXPECT_FALSE(result.in_front);
  EXPECT_LT(result.position.z(), 0);
}

TEST(Triangulate, ParallelRaysAndNonsenseFail) {
  RayView views[2] = {{Vec2(0.1, 0.2), camera_at(Vec3(-1, 0, 0), Vec3::Zero())},
                      {Vec2(0.1, 0.2), camera_at(Vec3(1, 0, 0), Vec3::Zero())}};
  TriangulatedPoint result;
  EXPECT_TRUE(triangulate(views, 2, result).is(StatusCode::numerical_failure));
  EXPECT_TRUE(triangulate(views, 1, result).is(StatusCode::invalid_argument));
  EXPECT_TRUE(triangulate(views, 0, result).is(StatusCode::invalid_argument));
  views[0].normalised.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(triangulate(views, 2, result).is(StatusCode::numerical_failure));
}

}  // namespace
}  // namespace ilp
