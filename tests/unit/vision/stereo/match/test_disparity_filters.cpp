// The filters after the matcher, on maps small enough to know the answer.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/disparity_border.hpp"
#include "fsw/vision/stereo/match/disparity_smoothing.hpp"
#include "fsw/vision/stereo/match/segment_filter.hpp"

namespace ilp {
namespace {

struct Map {
  std::int32_t width, height;
  std::vector<float> disparity, sigma;
  std::vector<DisparityKind> kind;

  Map(std::int32_t w, std::int32_t h)
      : width(w),
        height(h),
        disparity(static_cast<std::size_t>(w * h), 0),
        sigma(disparity.size(), 1),
        kind(disparity.size()) {}
  [[nodiscard]] ImageView<float> d() { return {disparity.data(), width, height}; }
  [[nodiscard]] ImageView<float> s() { return {sigma.data(), width, height}; }
  [[nodiscard]] DisparityView view() { return {d(), s(), {kind.data(), width, height}}; }
};

void smooth(Map& map, float max_step_px) {
  const auto workspace = std::make_unique<SmoothingWorkspace>();
  for (std::int32_t y = 0; y < map.height + smoothing_radius; ++y) smooth_row(map.view(), y, max_step_px, *workspace);
}

/// A slope seen by both images through masks with a slanted left end; disparities reach 8 to 14 px.
class DisparityBorder : public ::testing::Test {
 protected:
  static constexpr std::int32_t width = 80, height = 40;

  DisparityBorder() {
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        map.d().at(x, y) = truth(x, y);
        left.at(index(x, y)) = x >= first_column(y) ? 255 : 0;
        right.at(index(x, y)) = x < width - 20 ? 255 : 0;
        if (left.at(index(x, y)) == 0 || !seen_right(x, y)) map.s().at(x, y) = 0;
      }
    }
  }
  static float truth(std::int32_t x, std::int32_t y) {
    return 8.0F + 0.05F * static_cast<float>(x) + 0.05F * static_cast<float>(y);
  }
  static std::int32_t first_column(std::int32_t y) { return 20 + y / 4; }
  static bool seen_right(std::int32_t x, std::int32_t y) {
    return static_cast<double>(x) - static_cast<double>(truth(x, y)) < width - 20;
  }
  static std::size_t index(std::int32_t x, std::int32_t y) { return static_cast<std::size_t>(y * width + x); }
  void check() {
    const auto workspace = std::make_unique<BorderWorkspace>();
    for (std::int32_t y = 0; y < height; ++y) {
      check_border_row({left.data(), width, height}, {right.data(), width, height}, params, y, map.d(), map.s(),
                       *workspace);
    }
  }

  Map map{width, height};
  std::vector<std::uint8_t> left = std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height), right = left;
  StereoParams params;
};

TEST_F(DisparityBorder, ASlopeStaysWhole) {
  const std::vector<float> before = map.sigma;
  check();
  EXPECT_EQ(map.sigma, before);
}

TEST_F(DisparityBorder, WhatLeavesTheGroundAtEitherEndOfTheViewIsRefused) {
  const std::int32_t y = 20;
  const std::int32_t first = first_column(y);
  std::int32_t seen_last = width - 1;
  while (!seen_right(seen_last, y)) --seen_last;
  for (const std::int32_t x : {first, first + 1, seen_last, seen_last - 1})
    map.d().at(x, y) += x < width / 2 ? 1.2F : -1.2F;
  check();
  for (const std::int32_t x : {first, first + 1, seen_last, seen_last - 1}) EXPECT_EQ(map.s().at(x, y), 0) << x;
  EXPECT_GT(map.s().at(first + 2, y), 0);
}

TEST_F(DisparityBorder, InsideTheViewAndWithoutInnerNeighboursNothingIsRefused) {
  map.d().at(40, 20) += 5;
  // A sliver of the view, too narrow for a window.
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      if (y >= 36 || (x > first_column(y) + 3 && y >= 30)) map.s().at(x, y) = 0;
    }
  }
  for (std::int32_t y = 30; y < height; ++y) {
    for (std::int32_t x = first_column(y) + 4; x < width; ++x) left.at(index(x, y)) = 0;
  }
  map.d().at(first_column(35), 35) += 5;
  check();
  EXPECT_GT(map.s().at(40, 20), 0);
  EXPECT_GT(map.s().at(first_column(35), 35), 0);
}

TEST(DisparitySmoothing, PlanesAndStepsStayAsTheyAreWhateverIsMissing) {
  Map map(60, 40);
  Rng rng(3);
  const auto truth = [](std::int32_t x, std::int32_t y) { return 20.0 + 0.11 * x - 0.07 * y + (x >= 30 ? 5 : 0); };
  for (std::int32_t y = 0; y < map.height; ++y) {
    for (std::int32_t x = 0; x < map.width; ++x) {
      map.d().at(x, y) = static_cast<float>(truth(x, y));
      if (rng.below(3) == 0) map.s().at(x, y) = 0;
    }
  }
  smooth(map, 1.0F);
  for (std::int32_t y = 0; y < map.height; ++y) {
    for (std::int32_t x = 0; x < map.width; ++x) {
      if (map.s().at(x, y) > 0) {
        ASSERT_NEAR(map.d().at(x, y), truth(x, y), 1e-5);
      } else {
        ASSERT_EQ(map.d().at(x, y), 0);
      }
    }
  }
}

TEST(DisparitySmoothing, NoiseShrinks) {
  Map map(100, 80);
  Rng rng(4);
  double before = 0;
  for (float& d : map.disparity) {
    const double noise = 0.4 * (2 * rng.uniform() - 1);
    d = static_cast<float>(10 + noise);
    before += noise * noise;
  }
  smooth(map, 1.0F);
  double after = 0;
  for (const float d : map.disparity) after += (static_cast<double>(d) - 10) * (static_cast<double>(d) - 10);
  // 25 independent values would leave a fifth of the deviation; the border has fewer.
  EXPECT_LT(std::sqrt(after / before), 0.26);
}

TEST(DisparitySmoothing, TheErrorOfTheMeanIsThatOfTheNoiseThatRemains) {
  Map map(100, 80);
  Rng rng(6);
  constexpr double half_width = 0.1;
  for (float& d : map.disparity) d = static_cast<float>(10 + half_width * (2 * rng.uniform() - 1));
  std::fill(map.sigma.begin(), map.sigma.end(), static_cast<float>(half_width / std::sqrt(3.0)));
  smooth(map, 1.0F);
  int inside = 0, all = 0;
  double sigmas = 0;
  for (std::int32_t y = 2; y < map.height - 2; ++y) {
    for (std::int32_t x = 2; x < map.width - 2; ++x) {
      ++all;
      inside += std::fabs(map.d().at(x, y) - 10) <= 2 * map.s().at(x, y) ? 1 : 0;
      sigmas += static_cast<double>(map.s().at(x, y));
    }
  }
  EXPECT_GT(inside, 0.95 * all);
  // Slopes of the noise itself count, so that what is stated stays near the error of a single value.
  EXPECT_LT(sigmas / all, 1.5 * half_width / std::sqrt(3.0));
}

TEST(DisparitySmoothing, EdgesSlopesAndLonelyPixelsAreTrustedLess) {
  Map map(60, 40);
  std::fill(map.sigma.begin(), map.sigma.end(), 0.1F);
  for (std::int32_t y = 0; y < map.height; ++y) {
    for (std::int32_t x = 0; x < map.width; ++x) {
      map.d().at(x, y) = x < 20 ? 10.0F : 20.0F + (x > 40 ? 0.3F * static_cast<float>(x - 40) : 0.0F);
      if (y > 20 && x < 15 && (x % 8 != 4 || y % 8 != 4)) map.s().at(x, y) = 0;
    }
  }
  smooth(map, 1.0F);
  const float level = map.s().at(30, 10);
  EXPECT_LT(level, 0.1F);
  EXPECT_GT(map.s().at(19, 10), 3 * level);
  EXPECT_GT(map.s().at(50, 10), 3 * level);
  EXPECT_GT(map.s().at(4, 28), 3 * level);
}

TEST(DisparitySmoothing, ASettledErrorStaysAsItIs) {
  Map map(60, 40);
  std::fill(map.sigma.begin(), map.sigma.end(), 0.1F);
  map.s().at(30, 20) = 2.5F;
  map.view().kind.at(30, 20) = DisparityKind::resolved;
  smooth(map, 1.0F);
  EXPECT_EQ(map.s().at(30, 20), 2.5F);
  EXPECT_LT(map.s().at(31, 20), 0.1F);
}

TEST(SegmentFilter, RemovesSmallIslandsAndKeepsLargeOnesOfAnyShape) {
  Map map(80, 60);
  std::fill(map.sigma.begin(), map.sigma.end(), 0.0F);
  const auto put = [&](std::int32_t x, std::int32_t y, float d) {
    map.d().at(x, y) = d;
    map.s().at(x, y) = 1;
  };
  // A thin U whose arms only meet at the bottom: 2 * 40 + 20 pixels; its arms have different disparities, joined by a
  // ramp.
  for (std::int32_t y = 5; y < 45; ++y) {
    put(10, y, 8);
    put(30, y, 18);
  }
  for (std::int32_t x = 10; x <= 30; ++x) put(x, 45, 8 + 0.5F * static_cast<float>(x - 10));
  // A block of 5x5, and a block of 7x7 that is two segments because its halves differ by 4 px.
  for (std::int32_t y = 0; y < 5; ++y) {
    for (std::int32_t x = 0; x < 5; ++x) put(50 + x, 10 + y, 5);
  }
  for (std::int32_t y = 0; y < 7; ++y) {
    for (std::int32_t x = 0; x < 7; ++x) put(50 + x, 30 + y, x < 3 ? 5.0F : 9.0F);
  }
  const auto workspace = std::make_unique<PixelForest>();
  for (std::int32_t y = 0; y < map.height; ++y) connect_segments_row(map.d(), map.s(), y, 1.0F, *workspace);
  for (std::int32_t y = 0; y < map.height; ++y) remove_small_segments_row(map.s(), y, 27, *workspace);
  int u_shape = 0;
  for (std::int32_t y = 5; y <= 45; ++y) {
    for (std::int32_t x = 10; x <= 30; ++x) u_shape += map.s().at(x, y) > 0 ? 1 : 0;
  }
  EXPECT_EQ(u_shape, 101);
  EXPECT_EQ(map.s().at(52, 12), 0);
  EXPECT_EQ(map.s().at(51, 33), 0);
  EXPECT_GT(map.s().at(55, 33), 0);
}

TEST(DepthRows, AStepInDisparityMakesNoDepthInBetween) {
  // Two level pinholes; the reference's pixels fall between those of the rectified image.
  CameraModel camera{100, 80, 100, 100, 49.5, 39.5};
  RectifiedPair pair;
  pair.width = 120;
  pair.height = 90;
  pair.focal_px = 113;
  pair.cx_left = 60.3;
  pair.cx_right = 57.3;
  pair.cy = 44.2;
  pair.baseline = 2;
  Map map(120, 90);
  for (std::int32_t y = 0; y < 90; ++y) {
    for (std::int32_t x = 0; x < 120; ++x) map.d().at(x, y) = x < 60 ? 13.0F : 33.0F;
  }
  map.s().at(20, 20) = 0;
  for (std::int32_t y = 0; y < 90; ++y) {
    for (std::int32_t x = 90; x < 120; ++x) map.view().kind.at(x, y) = DisparityKind::supported;
  }
  std::vector<float> inverse(8000);
  std::vector<float> sigma(8000);
  std::vector<std::uint64_t> supported(160);
  const DepthView depth{{inverse.data(), 100, 80}, {sigma.data(), 100, 80}, {supported.data(), 2, 80}};
  ASSERT_TRUE(depth_rows(pair, camera, map.view(), 0, 80, depth).ok());
  int far = 0;
  int near = 0;
  int invalid = 0;
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    if (!(sigma[i] > 0)) {
      ++invalid;
      continue;
    }
    const double z = 1 / static_cast<double>(inverse[i]);
    // Z = f b / (d - 3).
    far += std::fabs(z - 22.6) < 1e-4 ? 1 : 0;
    near += std::fabs(z - 226.0 / 30) < 1e-4 ? 1 : 0;
  }
  EXPECT_EQ(far + near + invalid, 8000);
  EXPECT_GT(far, 3500);
  EXPECT_GT(near, 3500);
  // One rectified pixel is the nearest of at most one reference pixel here.
  EXPECT_LE(invalid, 1);
  for (std::int32_t y = 0; y < 80; ++y) {
    for (std::int32_t x = 0; x < 100; ++x) {
      const auto column = static_cast<std::int32_t>(pair.focal_px * (x - camera.cx) / camera.fx + pair.cx_left);
      const std::uint64_t word = depth.supported.at(x / supported_bits, y);
      ASSERT_EQ((word >> (x % supported_bits) & 1U) != 0, column + 1 >= 90) << x;
    }
  }
  EXPECT_EQ(depth_rows(pair, camera, map.view(), 0, 81, depth).code, StatusCode::invalid_argument);
}

}  // namespace
}  // namespace ilp
