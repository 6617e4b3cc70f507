// The second opinion on overlap: known warps, unrelated images, recorded facades.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "fsw/vision/twoview/feature_overlap.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640;
constexpr std::int32_t height = 480;

test::Image textured(double shift_x, double rotation, std::uint64_t seed) {
  Similarity2 world_from_image{.rotation_rad = rotation, .shift_x_px = shift_x};
  return test::render_texture(width, height, world_from_image, 1, 0, 1, seed);
}

OverlapResult measure(const test::Image& a, const test::Image& b) {
  static auto workspace = std::make_unique<FeatureOverlapWorkspace>();
  OverlapResult result;
  EXPECT_TRUE(measure_overlap_by_features(a.view(), b.view(), 1, *workspace, result).ok());
  return result;
}

TEST(FeatureOverlap, FindsAKnownShift) {
  for (const double shift : {20.0, 100.0, 200.0}) {
    const OverlapResult result = measure(textured(0, 0, 5), textured(shift, 0, 5));
    ASSERT_EQ(result.verdict, OverlapVerdict::ok) << shift;
    EXPECT_NEAR(result.overlap, 1 - shift / width, 0.01) << shift;
    // The plane maps a's pixel to where b sees it.
    EXPECT_NEAR(result.plane_b_from_a[2], -shift, 1.0);
    EXPECT_NEAR(result.plane_b_from_a[0], 1, 0.01);
  }
}

TEST(FeatureOverlap, TellsTheSimilarityToo) {
  const double shift = 90, rotation = 0.06;
  const OverlapResult result = measure(textured(0, 0, 5), textured(shift, rotation, 5));
  ASSERT_EQ(result.verdict, OverlapVerdict::ok);
  // x_a = R x_b + shift.
  EXPECT_NEAR(result.b_from_a.scale, 1, 0.005);
  EXPECT_NEAR(result.b_from_a.rotation_rad, -rotation, 0.005);
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  const double c = result.b_from_a.scale * std::cos(result.b_from_a.rotation_rad);
  const double s = result.b_from_a.scale * std::sin(result.b_from_a.rotation_rad);
  EXPECT_NEAR(c * cx - s * cy + result.b_from_a.shift_x_px, std::cos(rotation) * (cx - shift) + std::sin(rotation) * cy,
              0.5);
  EXPECT_NEAR(s * cx + c * cy + result.b_from_a.shift_y_px,
              -std::sin(rotation) * (cx - shift) + std::cos(rotation) * cy, 0.5);
}

TEST(FeatureOverlap, UnrelatedGroundIsUnknown) {
  for (int place = 1; place <= 8; ++place) {
    const double far = 5000.0 * place;
    EXPECT_EQ(measure(textured(0, 0, 5), textured(far, 0, 5)).verdict, OverlapVerdict::overlap_unknown) << far;
  }
}

TEST(FeatureOverlap, BlankImagesAreUnknown) {
  test::Image blank(width, height);
  EXPECT_EQ(measure(blank, blank).verdict, OverlapVerdict::overlap_unknown);
  EXPECT_EQ(measure(textured(0, 0, 5), blank).verdict, OverlapVerdict::overlap_unknown);
}

TEST(FeatureOverlap, BridgesTheFacadesThatCorrelationCannot) {
  const std::string folder = "strecha_entry_p10";
  const std::vector<test::StripImage> strip = test::read_strip(folder);
  if (strip.empty()) GTEST_SKIP() << folder << " is not there";
  // The facade is nearly a plane, so that matches under its homography satisfy the true epipolar geometry.
  for (std::size_t i = 0; i + 1 < strip.size(); ++i) {
    const OverlapResult result =
        measure(test::read_strip_image(folder, strip[i].name), test::read_strip_image(folder, strip[i + 1].name));
    ASSERT_EQ(result.verdict, OverlapVerdict::ok) << strip[i].name;
    const double* h = result.plane_b_from_a;
    std::vector<double> distances;
    for (int y = 100; y < 450; y += 50) {
      for (int x = 100; x < 700; x += 50) {
        const double w = h[6] * x + h[7] * y + h[8];
        const double xb = (h[0] * x + h[1] * y + h[2]) / w;
        const double yb = (h[3] * x + h[4] * y + h[5]) / w;
        distances.push_back(test::epipolar_distance(strip[i], strip[i + 1], x, y, xb, yb));
      }
    }
    std::sort(distances.begin(), distances.end());
    EXPECT_LT(distances[distances.size() / 2], 8) << strip[i].name;
  }
}

}  // namespace
}  // namespace ilp
