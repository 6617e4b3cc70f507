// The map of a world against the world itself, sampled place by place.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/world/orbital_map.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::world {
namespace {

constexpr double west = -40.3, north = 55.7, pixel = 1.1;

OrbitalMapParams exact() {
  OrbitalMapParams params;
  params.pixel_m = pixel;
  params.noise = 0;
  params.height_sigma_m = 0;
  return params;
}

TEST(OrbitalMap, PostsAreMeansOfTheGroundAboutThem) {
  const Terrain terrain(scenario_preset("mars-plains").world);
  const OrbitalMap map = render_orbital_map(terrain, west, north, 128, 64, exact());
  ASSERT_EQ(map.heights.width, 33);
  ASSERT_EQ(map.heights.height, 17);
  for (const auto& [i, j] : {std::pair{0, 0}, {32, 16}, {16, 8}, {17, 3}, {5, 16}}) {
    const double x = west + 4 * pixel * i, y = north - 4 * pixel * j;
    double sum = 0;
    constexpr int side = 44;
    for (int b = 0; b < side; ++b) {
      for (int a = 0; a < side; ++a) {
        sum += terrain.height(x + ((a + 0.5) / side - 0.5) * 4 * pixel, y + ((b + 0.5) / side - 0.5) * 4 * pixel);
      }
    }
    EXPECT_NEAR(double{map.heights.at(i, j)}, sum / (side * side), 0.02) << i << " " << j;
  }
}

TEST(OrbitalMap, PixelsAreMeansOfTheLightAboutThem) {
  const Terrain terrain(scenario_preset("mars-plains").world);
  const OrbitalMap map = render_orbital_map(terrain, west, north, 128, 64, exact());
  const double post = terrain.params().post_spacing_m, spread = 0.5 * pixel;
  for (const auto& [column, row] : {std::pair{0, 0}, {127, 63}, {64, 32}, {63, 31}, {20, 50}}) {
    const double x = west + (column + 0.5) * pixel, y = north - (row + 0.5) * pixel;
    const SurfacePatch patch = terrain.patch({x - 3, y - 3, x + 3, y + 3});
    // A square smoothed by a Gaussian, by brute force over the posts.
    const auto weight = [&](double d) {
      double sum = 0;
      for (int k = 0; k < 22; ++k) {
        const double u = d - ((k + 0.5) / 22 - 0.5) * pixel;
        sum += std::exp(-u * u / (2 * spread * spread));
      }
      return sum;
    };
    double sum = 0, weights = 0;
    for (std::int32_t j = 0; j < patch.rows; ++j) {
      for (std::int32_t i = 0; i < patch.columns; ++i) {
        const double px = (patch.first_i + i) * post, py = (patch.first_j + j) * post;
        const double w = weight(px - x) * weight(py - y);
        sum += w * double{patch.radiance[patch.index(i, j)]} * terrain.detail(px, py, post);
        weights += w;
      }
    }
    EXPECT_NEAR(double{map.light.at(column, row)}, sum / weights, 0.01) << column << " " << row;
  }
}

TEST(OrbitalMap, ErrorsAreAsLargeAsStatedAndTheSameInEveryRun) {
  WorldParams plane = scenario_preset("mars-plains").world;
  plane.ruggedness = 0;
  plane.albedo_contrast = 0;
  const Terrain terrain(plane);
  OrbitalMapParams params = exact();
  params.noise = 0.03;
  params.height_sigma_m = 0.7;
  const OrbitalMap map = render_orbital_map(terrain, west, north, 512, 512, params);
  host::Raster<float> noise = map.light;
  const OrbitalMap without = render_orbital_map(terrain, west, north, 512, 512, exact());
  for (std::size_t i = 0; i < noise.samples.size(); ++i) noise.samples[i] -= without.light.samples[i];
  const auto spread_of = [](const host::Raster<float>& values) {
    double sum = 0, squares = 0;
    for (const float value : values.samples) {
      sum += double{value};
      squares += double{value} * double{value};
    }
    const auto n = static_cast<double>(values.samples.size());
    return std::sqrt(squares / n - sum / n * (sum / n));
  };
  EXPECT_NEAR(spread_of(noise), 0.03, 0.002);
  EXPECT_NEAR(spread_of(map.heights), 0.7, 0.08);
  // Smooth: neighbours differ by less than two posts taken at random.
  double steps = 0;
  for (std::int32_t j = 0; j < 129; ++j) {
    for (std::int32_t i = 1; i < 129; ++i) {
      const double step = double{map.heights.at(i, j)} - double{map.heights.at(i - 1, j)};
      steps += step * step / (129 * 128);
    }
  }
  // The correlation of white noise smoothed by a Gaussian of one post is exp(-1/4) at one post.
  EXPECT_NEAR(steps / (2 * 0.49), 1 - std::exp(-0.25), 0.05);
  const OrbitalMap again = render_orbital_map(terrain, west, north, 512, 512, params);
  EXPECT_EQ(again.light.samples, map.light.samples);
  EXPECT_EQ(again.heights.samples, map.heights.samples);
  params.seed = 2;
  EXPECT_NE(render_orbital_map(terrain, west, north, 512, 512, params).heights.samples, map.heights.samples);
}

TEST(OrbitalMap, ParametersOutOfTheirRangeAreNamed) {
  const Terrain terrain(scenario_preset("mars-plains").world);
  OrbitalMapParams params = exact();
  EXPECT_THROW(static_cast<void>(render_orbital_map(terrain, 0, 0, 100, 64, params)), std::invalid_argument);
  params.pixel_m = 0.05;
  EXPECT_THROW(static_cast<void>(render_orbital_map(terrain, 0, 0, 64, 64, params)), std::invalid_argument);
  params = exact();
  params.spread_px = 5;
  EXPECT_THROW(static_cast<void>(render_orbital_map(terrain, 0, 0, 64, 64, params)), std::invalid_argument);
}

}  // namespace
}  // namespace ilp::world
