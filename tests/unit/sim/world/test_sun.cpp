// Shadows end where trigonometry says, however long they are, and light does not depend on what is lit with it.

#include "sim/world/sun.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {
namespace {

struct Posts {
  std::int32_t columns, rows;
  std::vector<double> height;

  [[nodiscard]] double at(std::int32_t i, std::int32_t j) const {
    return height[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)];
  }
};

std::int32_t lit_columns(const Posts& posts, const PostMargin& m) {
  return posts.columns - m.left - m.right;
}

/// Direct light from the definition: the way to the sun, sampled where it crosses a lattice line.
double light_by_hand(const Posts& posts, std::int32_t i, std::int32_t j, double azimuth, double elevation,
                     double spacing, double range) {
  const double sx = std::cos(azimuth), sy = std::sin(azimuth);
  const bool along_x = std::fabs(sx) >= std::fabs(sy);
  const double per_line = 1 / std::fabs(along_x ? sx : sy);  // level way between lines, posts
  double horizon = posts.at(i, j);
  for (int k = 1; k * per_line * spacing * std::tan(elevation) <= range + 1e-9; ++k) {
    const double x = i + k * per_line * sx, y = j + k * per_line * sy;
    const double cross = along_x ? y : x;
    const auto main = static_cast<std::int32_t>(std::lround(along_x ? x : y));
    const auto before = static_cast<std::int32_t>(std::floor(cross + 1e-9));
    const double weight = cross - before;
    const double a = along_x ? posts.at(main, before) : posts.at(before, main);
    const double b = along_x ? posts.at(main, before + 1) : posts.at(before + 1, main);
    horizon = std::max(horizon, a + (b - a) * weight - k * per_line * spacing * std::tan(elevation));
  }
  const Vec3 normal(-(posts.at(i + 1, j) - posts.at(i - 1, j)) / (2 * spacing),
                    -(posts.at(i, j + 1) - posts.at(i, j - 1)) / (2 * spacing), 1);
  const Vec3 sun(std::cos(elevation) * sx, std::cos(elevation) * sy, std::sin(elevation));
  const double cosine = std::max(0.0, normal.dot(sun) / normal.norm());
  return cosine / std::sin(elevation) * (1 - std::min(1.0, (horizon - posts.at(i, j)) / spacing));
}

// Sparse towers, so that most of the way is skipped and what stands on it is not.
Posts towers(std::int32_t columns, std::int32_t rows, double range) {
  Posts posts{columns, rows, {}};
  Rng rng(7);
  for (std::int32_t k = 0; k < columns * rows; ++k) {
    const double u = rng.uniform();
    posts.height.push_back(u > 0.999 ? range * rng.uniform() : 0.02 * range * u);
  }
  return posts;
}

TEST(Sunlight, IsWhatTheWayToTheSunSaysPostByPost) {
  constexpr double spacing = 0.5, range = 8;
  for (const double elevation : {0.12, 0.5, 1.2, 1.5707}) {
    for (const double azimuth : {0.0, 0.3, 0.785398163397448, 1.2, 2.2, 3.4, 4.0, 5.2, -0.4}) {
      const Sunlight sun(azimuth, elevation, spacing, range);
      const PostMargin& m = sun.margin();
      const Posts posts = towers(70 + m.left + m.right, 40 + m.below + m.above, range);
      std::vector<double> light;
      sun.direct(posts.height, posts.columns, posts.rows, light);
      ASSERT_EQ(light.size(), 70U * 40U);
      std::size_t dark = 0;
      for (std::int32_t j = 0; j < 40; ++j) {
        for (std::int32_t i = 0; i < 70; ++i) {
          const double expected = light_by_hand(posts, i + m.left, j + m.below, azimuth, elevation, spacing, range);
          ASSERT_NEAR(light[static_cast<std::size_t>(j * 70 + i)], expected, 1e-6)
              << i << "," << j << " sun " << azimuth << " " << elevation;
          dark += expected == 0;
        }
      }
      EXPECT_EQ(dark > 20, elevation < 0.2) << "shadows that are long only under a low sun";
    }
  }
}

// A wall's shadow is height / tan(elevation) long: here more than a thousand posts.
TEST(Sunlight, ShadowOfAWallIsAsLongAsTheSunIsLow) {
  constexpr double spacing = 0.25, wall_m = 20, elevation = 0.06;
  for (const bool east : {true, false}) {
    const Sunlight sun(east ? 0 : 3.14159265358979, elevation, spacing, wall_m);
    const PostMargin& m = sun.margin();
    const double reach = wall_m / std::tan(elevation);
    ASSERT_GT(reach, 1000 * spacing);
    Posts posts{3000 + m.left + m.right, 1 + m.below + m.above, {}};
    posts.height.assign(static_cast<std::size_t>(posts.columns) * static_cast<std::size_t>(posts.rows), 0.0);
    const std::int32_t wall = m.left + 1500;
    for (std::int32_t j = 0; j < posts.rows; ++j) {
      posts.height[static_cast<std::size_t>(j * posts.columns + wall)] = wall_m;
    }
    std::vector<double> light;
    sun.direct(posts.height, posts.columns, posts.rows, light);
    for (std::int32_t k = 0; k < lit_columns(posts, m); ++k) {
      const double behind = (k - 1500) * spacing * (east ? -1 : 1);  // m from the wall, positive on its far side
      const double soft = spacing / std::tan(elevation);             // of the shadow's edge
      if (std::abs(k - 1500) < 2) continue;
      const double seen = light[static_cast<std::size_t>(k)];
      if (behind > 0 && behind < reach - soft) {
        ASSERT_EQ(seen, 0) << behind;
      } else if (behind < 0 || behind > reach) {
        ASSERT_NEAR(seen, 1, 1e-12) << behind;
      }
    }
  }
}

TEST(Sunlight, OfAPostIsTheSameInEveryPatch) {
  WorldParams world{.sun_elevation_rad = 0.12};
  const Terrain terrain(world);
  const SurfacePatch a = terrain.patch({0, 0, 30, 25});
  const SurfacePatch b = terrain.patch({11.3, 9.1, 47, 39});
  std::size_t compared = 0;
  for (std::int32_t j = b.first_j; j < a.first_j + a.rows; ++j) {
    for (std::int32_t i = b.first_i; i < a.first_i + a.columns; ++i, ++compared) {
      ASSERT_EQ(a.radiance[a.index(i - a.first_i, j - a.first_j)], b.radiance[b.index(i - b.first_i, j - b.first_j)]);
    }
  }
  EXPECT_GT(compared, 5000U);
}

}  // namespace
}  // namespace ilp::world
