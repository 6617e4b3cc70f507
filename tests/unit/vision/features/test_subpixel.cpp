#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/base/rng.hpp"
#include "fsw/vision/features/subpixel.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

struct SmoothImage {
  std::vector<std::uint16_t> pixels;
  SmoothView view;

  explicit SmoothImage(const test::Image& image) : pixels(image.pixels.size()) {
    smooth(image.view(), {pixels.data(), image.width, image.height});
    view = SmoothView(pixels.data(), image.width, image.height);
  }
};

TEST(Smooth, IsTheBinomialKernelExactly) {
  test::Image image(5, 5);
  image.view().at(2, 2) = 100;
  const SmoothImage out(image);
  EXPECT_EQ(out.view.at(2, 2), 400);
  EXPECT_EQ(out.view.at(1, 2), 200);
  EXPECT_EQ(out.view.at(3, 3), 100);
  EXPECT_EQ(out.view.at(0, 2), 0);
  // Constant images stay constant up to the border.
  test::Image grey(4, 3);
  std::fill(grey.pixels.begin(), grey.pixels.end(), std::uint8_t{7});
  for (const std::uint16_t v : SmoothImage(grey).pixels) EXPECT_EQ(v, 7 * 16);
}

TEST(Patch, CorrelationIsThatOfTheDefinition) {
  const SmoothImage image(test::render_texture(80, 60, {}, 1, 0, 1, 1));
  const auto p = std::make_unique<NormalizedPatch>(), q = std::make_unique<NormalizedPatch>();
  constexpr int side = 11, n = side * side;
  ASSERT_TRUE(extract_patch(image.view, 20, 30, {}, side, 0, *p));
  ASSERT_TRUE(extract_patch(image.view, 22, 31, {}, side, 0, *q));
  double sp = 0, sq = 0, spp = 0, sqq = 0, spq = 0;
  for (int v = -side / 2; v <= side / 2; ++v) {
    for (int u = -side / 2; u <= side / 2; ++u) {
      const double a = image.view.at(20 + u, 30 + v), b = image.view.at(22 + u, 31 + v);
      sp += a, sq += b, spp += a * a, sqq += b * b, spq += a * b;
    }
  }
  const double expected = (n * spq - sp * sq) / std::sqrt((n * spp - sp * sp) * (n * sqq - sq * sq));
  EXPECT_NEAR(static_cast<double>(correlate(*p, *q, side)) / normalized_patch_square, expected, 2e-3);
  EXPECT_NEAR(static_cast<double>(correlate(*p, *p, side)) / normalized_patch_square, 1.0, 2e-3);
}

TEST(Patch, OutsideOrFlatIsRefused) {
  const SmoothImage image(test::render_texture(80, 60, {}, 1, 0, 1, 1));
  const auto p = std::make_unique<NormalizedPatch>();
  EXPECT_TRUE(extract_patch(image.view, 8, 8, {}, 15, 0, *p));
  EXPECT_FALSE(extract_patch(image.view, 6.5F, 30, {}, 15, 0, *p));
  EXPECT_FALSE(extract_patch(image.view, 40, 53, {}, 15, 0, *p));
  EXPECT_FALSE(extract_patch(image.view, std::nanf(""), 30, {}, 15, 0, *p));
  EXPECT_FALSE(extract_patch(image.view, 40, 30, {}, 15, 200, *p));
}

// The same landscape seen under an affine warp about a random point, with another exposure: where the point lies in b
// is known.
TEST(SubPixel, RecoversKnownPositionsToAFewHundredths) {
  Rng rng(11);
  const auto patch = std::make_unique<PatchTemplate>();
  double squares = 0, worst = 0;
  int found = 0;
  constexpr int trials = 200, size = 48;
  for (int trial = 0; trial < trials; ++trial) {
    const auto random = [&](double range) { return range * (2 * rng.uniform() - 1); };
    const double world_x = 1000 * rng.uniform(), world_y = 1000 * rng.uniform();
    const double ax = 24 + random(0.5), ay = 24 + random(0.5), bx = 24 + random(0.5), by = 24 + random(0.5);
    const double scale = 1 + random(0.15), turn = random(0.2), shear = random(0.06);
    const double c = scale * std::cos(turn), s = scale * std::sin(turn);
    const double m[4] = {c, -s + shear, s, c};  // b_from_a
    const double det = m[0] * m[3] - m[1] * m[2];
    test::Image a(size, size), b(size, size);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double u = x - bx, v = y - by;
        const double wx = (m[3] * u - m[1] * v) / det, wy = (-m[2] * u + m[0] * v) / det;
        a.view().at(x, y) = static_cast<std::uint8_t>(
            std::clamp(test::fractal_texture(world_x + x - ax, world_y + y - ay, 5, 1) + random(1) + 0.5, 0.0, 255.0));
        b.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(
            0.8 * test::fractal_texture(world_x + wx, world_y + wy, 5, 1) + 20 + random(1) + 0.5, 0.0, 255.0));
      }
    }
    const SmoothImage smooth_a(a), smooth_b(b);
    ASSERT_TRUE(prepare_patch(smooth_a.view, static_cast<float>(ax), static_cast<float>(ay), 15, *patch));
    // Started from the right scale and rotation, as a prediction gives them, and a pixel off.
    PatchWarp warp{static_cast<float>(bx + 0.8),
                   static_cast<float>(by - 0.6),
                   {static_cast<float>(c), static_cast<float>(-s), static_cast<float>(s), static_cast<float>(c)},
                   0};
    if (!register_patch(*patch, smooth_b.view, warp) || warp.ncc < 0.8F) continue;
    const double error = std::hypot(warp.x - bx, warp.y - by);
    ++found;
    squares += error * error;
    worst = std::max(worst, error);
  }
  EXPECT_GT(found, trials * 9 / 10);
  // The bound of Cramer and Rao is 0.03 px for this texture and noise.
  EXPECT_LT(std::sqrt(squares / found), 0.06);
  EXPECT_LT(worst, 0.2);
}

TEST(SubPixel, AnEdgeDoesNotFixAPosition) {
  test::Image image(48, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 48; ++x) image.view().at(x, y) = x + y > 48 ? 180 : 60;
  }
  const auto patch = std::make_unique<PatchTemplate>();
  EXPECT_FALSE(prepare_patch(SmoothImage(image).view, 24, 24, 15, *patch));
}

}  // namespace
}  // namespace ilp
