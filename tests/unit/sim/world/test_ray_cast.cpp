// Rays end on the ground, where they meet it first: against a march that only knows heights, and known shapes.

#include "sim/world/ray_cast.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {
namespace {

// The walk over squares against a fine march that only knows heights.
TEST(RayCaster, FindsTheFirstMeetingWithTheGround) {
  const Terrain terrain{WorldParams{}};
  const SurfacePatch patch = terrain.patch({0, 0, 30, 30});
  const RayCaster caster(patch);
  const auto ground = [&](const Vec3& p) {
    const double column = p.x() / patch.spacing_m - patch.first_i;
    const double row = p.y() / patch.spacing_m - patch.first_j;
    const double i = std::floor(column);
    const double j = std::floor(row);
    const std::size_t at = patch.index(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
    const auto stride = static_cast<std::size_t>(patch.columns);
    const double u = column - i;
    const double v = row - j;
    return (1 - v) * ((1 - u) * patch.height_m[at] + u * patch.height_m[at + 1]) +
           v * ((1 - u) * patch.height_m[at + stride] + u * patch.height_m[at + stride + 1]);
  };
  Rng rng(11);
  for (int n = 0; n < 300; ++n) {
    const Vec3 origin(15 + 2 * rng.uniform(), 15 + 2 * rng.uniform(), 13);
    // Every tenth ray runs exactly along an axis.
    const Vec3 direction(n % 10 == 0 ? 0 : 1.2 * rng.uniform() - 0.6, n % 20 == 0 ? 0 : 1.2 * rng.uniform() - 0.6, -1);
    const double t = caster.hit(origin, direction);
    ASSERT_GT(t, 0);
    EXPECT_NEAR((origin + t * direction).z(), ground(origin + t * direction), 1e-9);
    for (double before = 0; before < t - 1e-6; before += 0.003) {
      const Vec3 p = origin + before * direction;
      ASSERT_GT(p.z(), ground(p) - 1e-9) << "went through the ground before " << t;
    }
  }
}

TEST(RayCaster, RayThatLeavesThePatchIsAMiss) {
  const Terrain terrain{WorldParams{}};
  const SurfacePatch patch = terrain.patch({0, 0, 10, 10});
  const RayCaster caster(patch);
  EXPECT_LT(caster.hit(Vec3(5, 5, 50), Vec3(1, 0, -0.5)), 0);
  EXPECT_LT(caster.hit(Vec3(100, 5, 50), Vec3(0, 0, -1)), 0);
  EXPECT_LT(caster.hit(Vec3(5, 5, 50), Vec3(0, 0, 1)), 0);
}
SurfacePatch shaped(std::int32_t side, const std::function<double(double x, double y)>& height) {
  SurfacePatch patch{.columns = side, .rows = side};
  for (std::int32_t j = 0; j < side; ++j) {
    for (std::int32_t i = 0; i < side; ++i) patch.height_m.push_back(static_cast<float>(height(i, j)));
  }
  patch.radiance.assign(patch.height_m.size(), 1.0F);
  return patch;
}

/// Rays of a tile of 9x9 directions around `axis`; the first four are the corners.
std::vector<LatticeRay> bundle(double x, double y, double z, double axis_x, double axis_y, double half_width) {
  std::vector<LatticeRay> rays;
  for (const double v : {-1.0, 1.0}) {
    for (const double u : {-1.0, 1.0}) rays.push_back({x, y, z, axis_x + u * half_width, axis_y + v * half_width, -1});
  }
  for (int k = 0; k < 81; ++k) {
    rays.push_back({x, y, z, axis_x + (k % 9 - 4) * 0.23 * half_width, axis_y + (k / 9 - 4) * 0.23 * half_width, -1});
  }
  return rays;
}

// What a bundle shares may make a ray faster, never different: in gentle and in broken ground, steep and grazing.
TEST(RayCaster, RayOfABundleEndsWhereItWouldAlone) {
  Rng rng(5);
  std::size_t single = 0, broken = 0;
  for (const double roughness : {0.0, 0.3, 1.0, 4.0}) {
    WorldParams world{.relief_m = 0.001 + 4 * roughness, .rock_density = roughness > 0 ? 0.5 : 0};
    const Terrain terrain(world);
    const SurfacePatch patch = terrain.patch({-20, -20, 140, 140});
    const RayCaster caster(patch);
    for (int n = 0; n < 200; ++n) {
      const double tilt = 12 * (2 * rng.uniform() - 1);  // posts per metre: up to 67 degrees off straight down
      const double height = world.relief_m + 3;
      const std::vector<LatticeRay> rays =
          bundle(400 - tilt * height, 400, height, tilt, 2 * (rng.uniform() - 0.5), 0.05 * rng.uniform());
      const HitInterval interval = caster.narrow({rays.data(), 4});
      (interval.single ? single : broken) += 1;
      for (const LatticeRay& ray : rays) {
        const double alone = caster.hit(ray);
        ASSERT_GT(alone, 0);
        ASSERT_GE(alone, interval.near);
        ASSERT_LE(alone, interval.far);
        const double guess = interval.near + rng.uniform() * (interval.far - interval.near);
        ASSERT_NEAR(caster.hit(ray, interval, guess), alone, 1e-9 * alone);
      }
    }
  }
  EXPECT_GT(single, 100U);
  EXPECT_GT(broken, 50U);
}

// The upper half of a ball on a plane, against the sphere's equation; its facets are a post wide.
TEST(RayCaster, HitsABallWhereItsEquationSays) {
  constexpr double radius = 400;
  const Vec3 centre(500, 500, 0);
  const SurfacePatch patch = shaped(1001, [&](double x, double y) {
    const double r2 = (x - 500) * (x - 500) + (y - 500) * (y - 500);
    return r2 < radius * radius ? std::sqrt(radius * radius - r2) : 0;
  });
  const RayCaster caster(patch);
  Rng rng(3);
  std::size_t hits = 0;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 origin(300 + 400 * rng.uniform(), 300 + 400 * rng.uniform(), 1200);
    const Vec3 target(200 + 600 * rng.uniform(), 200 + 600 * rng.uniform(), 200);
    const Vec3 direction = (target - origin) / 1000;
    const Vec3 from_centre = origin - centre;
    const double a = direction.squaredNorm(), b = from_centre.dot(direction);
    const double root = b * b - a * (from_centre.squaredNorm() - radius * radius);
    if (root < 0) continue;
    const double t = (-b - std::sqrt(root)) / a;
    if ((from_centre + t * direction).z() < 200) continue;  // facets are coarse where the ball is steep
    EXPECT_NEAR(caster.hit(origin, direction), t, 1e-5 * t) << n;
    ++hits;
  }
  EXPECT_GT(hits, 1000U);
}

TEST(RayCaster, HitsAnInclinedPlaneExactly) {
  const SurfacePatch patch = shaped(129, [](double x, double y) { return 0.25 * x - 0.5 * y; });
  const RayCaster caster(patch);
  Rng rng(4);
  for (int n = 0; n < 500; ++n) {
    const Vec3 origin(64 + 10 * rng.uniform(), 64 + 10 * rng.uniform(), 60);
    const Vec3 direction(0.5 * rng.uniform() - 0.25, 0.5 * rng.uniform() - 0.25, -1);
    const Vec3 normal(-0.25, 0.5, 1);
    EXPECT_NEAR(caster.hit(origin, direction), -normal.dot(origin) / normal.dot(direction), 1e-10);
  }
}

}  // namespace
}  // namespace ilp::world
