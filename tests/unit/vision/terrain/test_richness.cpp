// The index ranks what a geologist would, and reacts neither to exposure nor to the strip's arbitrary scale.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <type_traits>

#include "fsw/vision/terrain/richness.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {
namespace {

static_assert(std::is_trivially_copyable_v<RichnessHistory>);

struct Crater {
  double x, y, radius;
};
constexpr Crater craters[] = {{-15, 8, 9}, {14, -10, 12}, {22, 17, 6}, {-28, -18, 7}, {0, 25, 5}, {-4, -6, 4}};

/// Bowls with raised rims (depth a fifth of the diameter), gently rolling ground between.
double cratered(double x, double y) {
  double z = 0.6 * std::sin(x / 9) * std::cos(y / 11);
  for (const Crater& c : craters) {
    const double r = std::sqrt((x - c.x) * (x - c.x) + (y - c.y) * (y - c.y)) / c.radius;
    const double rim = 0.08 * c.radius;
    z += r < 1 ? 0.4 * c.radius * (r * r - 1) + rim : rim * std::exp(-(r - 1) * 4);
  }
  return z;
}
double rolling(double x, double y) {
  return 0.6 * std::sin(x / 9) * std::cos(y / 11);
}
double tilted(double x, double y) {
  return 0.2 * x - 0.1 * y;
}

struct Scene {
  CameraModel camera;
  Image image;
  std::vector<float> inverse_depth, sigma;
  std::vector<std::uint8_t> mask;
};

/// Lambertian ground of faint pattern under a low sun, with exact depth.
Scene make_scene(const Terrain& terrain, double unit = 1, double gain = 1) {
  Scene s{.camera = distorting_camera(240, 180), .image = Image(240, 180)};
  Rng rng(3);
  const RigidTransform pose = looking_down({0, 0, 100});
  for (std::int32_t y = 0; y < 180; ++y) {
    for (std::int32_t x = 0; x < 240; ++x) {
      const Vec3 p = ground_point(s.camera, pose, terrain, x, y);
      const double e = 0.05;
      const Vec3 normal = Vec3(terrain(p.x() - e, p.y()) - terrain(p.x() + e, p.y()),
                               terrain(p.x(), p.y() - e) - terrain(p.x(), p.y() + e), 2 * e)
                              .normalized();
      const double light = std::max(0.05, normal.dot(Vec3(-0.7, 0.3, 0.65).normalized()));
      const double pattern = 1 + 0.5 * (fractal_texture(2 * p.x(), 2 * p.y(), 3, 2) - 128) / 128;
      const double grey = gain * 150 * light * pattern + 2 * rng.uniform() - 1;
      s.image.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0));
      s.inverse_depth.push_back(static_cast<float>(1 / ((pose * p).z() * unit)));
      s.sigma.push_back(static_cast<float>(1e-5 / unit));
      s.mask.push_back(255);
    }
  }
  return s;
}

struct Score {
  Status status;
  RichnessCues cues;
  double index = 0;
};

Score score(const Scene& s, const RichnessHistory& history = {}, const RichnessParams& params = {}) {
  static const auto workspace = std::make_unique<RichnessWorkspace>();
  Score r;
  r.status =
      score_richness(s.camera, s.image.view(), {s.inverse_depth.data(), s.camera.width, s.camera.height},
                     {s.sigma.data(), s.camera.width, s.camera.height},
                     {s.mask.data(), s.camera.width, s.camera.height}, params, history, *workspace, r.cues, r.index);
  return r;
}

void print(const char* name, const Score& s) {
  const RichnessCues& c = s.cues;
  std::printf(
      "%s %.3f: gradient %.4f %.4f entropy %.2f contrast %.3f relief %.4f slope %.3f %.3f roughness %.4f %.4f "
      "curvature %.3f\n",
      name, s.index, c.gradient_fine, c.gradient_coarse, c.entropy, c.contrast, c.relief, c.slope_steep, c.slope_excess,
      c.roughness_fine, c.roughness_coarse, c.curvature);
}

TEST(Richness, CratersOutrankRollingGroundAndThatAPlane) {
  const Score rich = score(make_scene(cratered));
  const Score plain = score(make_scene(rolling));
  const Score flat = score(make_scene(tilted));
  print("cratered", rich);
  print("rolling", plain);
  print("tilted plane", flat);
  ASSERT_TRUE(rich.status.ok() && plain.status.ok() && flat.status.ok());
  EXPECT_GT(rich.index, plain.index + 0.15);
  EXPECT_GT(plain.index, flat.index + 0.02);
  EXPECT_GT(rich.cues.gradient_coarse, 1.5 * plain.cues.gradient_coarse);
  EXPECT_GT(rich.cues.curvature, 3 * plain.cues.curvature);
  EXPECT_GT(rich.cues.roughness_coarse, 3 * plain.cues.roughness_coarse);
}

TEST(Richness, APlaneHasNoReliefSlopeOrRoughnessHoweverTilted) {
  const RichnessCues c = score(make_scene(tilted)).cues;
  ASSERT_TRUE(c.has_terrain);
  EXPECT_LT(c.relief, 1e-3);
  EXPECT_LT(c.slope_steep, 5e-3);
  EXPECT_LT(c.roughness_fine, 2e-3);
  EXPECT_LT(c.roughness_coarse, 1e-3);
  EXPECT_LT(c.curvature, 1e-3);
}

TEST(Richness, SlopeAndReliefOfAKnownHillAreRight) {
  // Ridges h = a sin(k x). The least-squares slope over a window of side s is 3 (sin u - u cos u) / u^3 of the slope in
  // its middle, u = k s / 2; relief from percentiles of a sine 2 a sin(0.45 pi).
  const double pi = 3.14159265358979;
  const double a = 1.5;
  const double k = 2 * pi / 40;
  const Scene scene = make_scene([&](double x, double) { return a * std::sin(k * x); });
  const RichnessCues c = score(scene).cues;
  const double u = 0.5 * k * 36 * 100 / scene.camera.fx;
  const double steepest = a * k * 3 * (std::sin(u) - u * std::cos(u)) / (u * u * u);
  EXPECT_NEAR(c.slope_steep, steepest, 0.05 * steepest);
  // The median of |cos| is 0.707, over whole ridges.
  EXPECT_NEAR(c.slope_excess, 0.293 * steepest, 0.1 * steepest);
  EXPECT_NEAR(c.relief, 2 * a * std::sin(0.45 * pi) / 100, 0.004);
}

TEST(Richness, AStepIsRougherThanTheSlopeThatRisesAsMuch) {
  const Score scarp = score(make_scene([](double x, double) { return 3 * std::clamp(x / 2, -1.0, 1.0); }));
  const Score hillside = score(make_scene([](double x, double) { return 3 * std::clamp(x / 40, -1.0, 1.0); }));
  EXPECT_GT(scarp.cues.slope_excess, 3 * hillside.cues.slope_excess);
  EXPECT_GT(scarp.cues.roughness_coarse, 3 * hillside.cues.roughness_coarse);
  EXPECT_GT(scarp.index, hillside.index + 0.05);
}

TEST(Richness, StonesOnAFewTilesAreSeenInTheImageAlone) {
  Scene scene = make_scene(rolling);
  std::fill(scene.sigma.begin(), scene.sigma.end(), 0.0F);
  const Score before = score(scene);
  Rng rng(7);
  for (int stone = 0; stone < 60; ++stone) {
    // In a corner of a tenth of the image, each with its shadow.
    const auto x = static_cast<std::int32_t>(150 + rng.below(80));
    const auto y = static_cast<std::int32_t>(20 + rng.below(50));
    for (std::int32_t dy = 0; dy < 3; ++dy) {
      for (std::int32_t dx = 0; dx < 3; ++dx) {
        scene.image.view().at(x + dx, y + dy) = 190;
        scene.image.view().at(x + dx + 3, y + dy) = 25;
      }
    }
  }
  const Score after = score(scene);
  EXPECT_GT(after.cues.contrast, 1.5 * before.cues.contrast);
  EXPECT_GT(after.cues.gradient_fine, 1.5 * before.cues.gradient_fine);
  EXPECT_GT(after.index, before.index + 0.05);
}

TEST(Richness, GainDoesNotMatter) {
  const Score normal = score(make_scene(cratered));
  const Score dark = score(make_scene(cratered, 1, 0.6));
  EXPECT_NEAR(normal.index, dark.index, 0.02);
  EXPECT_NEAR(normal.cues.contrast / dark.cues.contrast, 1, 0.1);
  EXPECT_NEAR(normal.cues.gradient_coarse / dark.cues.gradient_coarse, 1, 0.1);
  // Noise does not change with the light.
  EXPECT_NEAR(normal.cues.gradient_fine / dark.cues.gradient_fine, 1, 0.2);
  EXPECT_NEAR(normal.cues.entropy, dark.cues.entropy, 0.25);
}

TEST(Richness, GroundOfStrongPatternIsNotRich) {
  // The same plane, its pattern five times as strong.
  Scene faint = make_scene(tilted);
  Scene strong = faint;
  for (std::size_t i = 0; i < strong.image.pixels.size(); ++i) {
    strong.image.pixels[i] =
        static_cast<std::uint8_t>(std::clamp(100 + 2.5 * (faint.image.pixels[i] - 90.0), 0.0, 255.0));
  }
  EXPECT_NEAR(score(strong).index, score(faint).index, 0.06);
}

TEST(Richness, TheUnitOfTheWorldDoesNotMatter) {
  const Score metres = score(make_scene(cratered));
  const Score baselines = score(make_scene(cratered, 0.037));
  EXPECT_NEAR(metres.index, baselines.index, 1e-4);
}

TEST(Richness, OnlyTheNewlySeenPartCounts) {
  Scene craters_all = make_scene(cratered);
  Scene mixed = make_scene(rolling);
  // The left half is covered ground and full of craters, the right half is new and plain.
  for (std::int32_t y = 0; y < 180; ++y) {
    for (std::int32_t x = 0; x < 120; ++x) {
      const auto i = static_cast<std::size_t>(y * 240 + x);
      mixed.image.pixels[i] = craters_all.image.pixels[i];
      mixed.inverse_depth[i] = craters_all.inverse_depth[i];
      mixed.mask[i] = 0;
    }
  }
  Scene alone = make_scene(rolling);
  for (std::size_t i = 0; i < alone.mask.size(); ++i) alone.mask[i] = mixed.mask[i];
  const Score with = score(mixed);
  const Score without = score(alone);
  EXPECT_DOUBLE_EQ(with.index, without.index);
  EXPECT_DOUBLE_EQ(with.cues.mask_fraction, 0.5);
}

TEST(Richness, TheUnusualScoresHigherThanTheUsual) {
  RichnessHistory history;
  const RichnessParams params;
  for (const double wavelength : {9.0, 9.5, 10.0, 8.5}) {
    const Score s = score(
        make_scene([&](double x, double y) { return 0.6 * std::sin(x / wavelength) * std::cos(y / 11); }), history);
    learn(s.cues, params, history);
  }
  const Score usual = score(make_scene(rolling), history);
  const Score unusual = score(make_scene(cratered), history);
  EXPECT_LT(usual.cues.novelty, 1);
  EXPECT_GT(unusual.cues.novelty, 3);
  EXPECT_GT(unusual.index, score(make_scene(cratered)).index);
}

TEST(Richness, WhatIsLongAgoFadesFromTheMemory) {
  RichnessParams params{.novelty_memory = 20};
  RichnessHistory history;
  const Score old_ground = score(make_scene(cratered));
  const Score new_ground = score(make_scene(rolling));
  for (int i = 0; i < 200; ++i) learn(old_ground.cues, params, history);
  RichnessCues seen = old_ground.cues;
  static_cast<void>(richness_index(params, history, seen));
  EXPECT_LT(seen.novelty, 0.01);
  for (int i = 0; i < 100; ++i) learn(new_ground.cues, params, history);
  EXPECT_EQ(history.count, 300U);
  RichnessCues again = old_ground.cues;
  static_cast<void>(richness_index(params, history, again));
  EXPECT_GT(again.novelty, 2);
  for (const double variance : history.variance) EXPECT_GE(variance, 0);
}

TEST(Richness, OtherHalvesStartTheMemoryAfresh) {
  RichnessParams params;
  RichnessHistory history;
  const Score s = score(make_scene(rolling));
  for (int i = 0; i < 10; ++i) learn(s.cues, params, history);
  params.relief.half *= 2;
  RichnessCues cues = s.cues;
  static_cast<void>(richness_index(params, history, cues));
  EXPECT_EQ(cues.novelty, 1);
  learn(s.cues, params, history);
  EXPECT_EQ(history.count, 1U);
}

TEST(Richness, MissingDepthOrAnEmptyMaskIsNoError) {
  Scene no_depth = make_scene(cratered);
  std::fill(no_depth.sigma.begin(), no_depth.sigma.end(), 0.0F);
  const Score image_only = score(no_depth);
  ASSERT_TRUE(image_only.status.ok());
  EXPECT_FALSE(image_only.cues.has_terrain);
  EXPECT_LT(image_only.index, score(make_scene(cratered)).index);
  Scene dull = make_scene(tilted);
  const double with_depth = score(dull).index;
  std::fill(dull.sigma.begin(), dull.sigma.end(), 0.0F);
  EXPECT_NEAR(score(dull).index, with_depth, 0.08);
  EXPECT_GT(image_only.index, 0.2);
  Scene covered = make_scene(rolling);
  std::fill(covered.mask.begin(), covered.mask.end(), std::uint8_t{0});
  const Score nothing = score(covered);
  ASSERT_TRUE(nothing.status.ok());
  EXPECT_EQ(nothing.index, 0);
  Scene black = make_scene(rolling);
  std::fill(black.image.pixels.begin(), black.image.pixels.end(), std::uint8_t{0});
  EXPECT_TRUE(score(black).status.ok());
  RichnessParams bad;
  bad.relief.half = 0;
  EXPECT_EQ(score(no_depth, {}, bad).status.code, StatusCode::invalid_argument);
}

}  // namespace
}  // namespace ilp::test
