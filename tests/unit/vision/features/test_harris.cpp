#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

Corners detect(const test::Image& image, const HarrisParams& params = {}) {
  static const auto workspace = std::make_unique<HarrisWorkspace>();
  Corners corners;
  const Status status = detect_corners(image.view(), params, *workspace, corners);
  EXPECT_TRUE(status.ok()) << status_name(status.code);
  return corners;
}

// A turned chessboard, each pixel the mean of 8x8 samples: its crossings are known exactly and have no preferred side.
struct Chessboard {
  double square_px = 40, rotation_rad = 0.3, origin_x = 13.37, origin_y = 7.81;

  [[nodiscard]] test::Image render(int width, int height) const {
    test::Image image(width, height);
    const double c = std::cos(rotation_rad), s = std::sin(rotation_rad);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        int white = 0;
        for (int k = 0; k < 64; ++k) {
          const double px = x + (k % 8 + 0.5) / 8 - 0.5 - origin_x, py = y + (k / 8 + 0.5) / 8 - 0.5 - origin_y;
          const auto u = static_cast<int>(std::floor((c * px + s * py) / square_px));
          const auto v = static_cast<int>(std::floor((-s * px + c * py) / square_px));
          white += (u + v) & 1;
        }
        image.view().at(x, y) = static_cast<std::uint8_t>(60 + 2 * white);
      }
    }
    return image;
  }
  [[nodiscard]] double distance_to_crossing(double x, double y) const {
    const double c = std::cos(rotation_rad), s = std::sin(rotation_rad);
    const double u = (c * (x - origin_x) + s * (y - origin_y)) / square_px;
    const double v = (-s * (x - origin_x) + c * (y - origin_y)) / square_px;
    return square_px * std::hypot(u - std::round(u), v - std::round(v));
  }
};

TEST(Harris, FindsChessboardCrossingsToAFractionOfAPixel) {
  const Chessboard board;
  const Corners corners = detect(board.render(320, 240));
  // 320 x 240 without the border holds (296 * 216) / 40^2 = 40 crossings, give or take those at its edge.
  EXPECT_GE(corners.size(), 32U);
  EXPECT_LE(corners.size(), 48U);
  for (const Corner& c : corners) EXPECT_LT(board.distance_to_crossing(c.x, c.y), 0.3) << c.x << " " << c.y;
}

TEST(Harris, BothVectorWidthsFindTheSameCorners) {
  const test::Image image = test::render_texture(403, 305, {1, 0, 1000, 2000}, 1, 0, 2, 1);
  const Corners wide = detect(image);
  use_vectors(VectorWidth::bytes16);
  const Corners narrow = detect(image);
  use_vectors(widest_vectors());
  ASSERT_GT(wide.size(), 300U);
  ASSERT_EQ(wide.size(), narrow.size());
  for (std::size_t i = 0; i < wide.size(); ++i) {
    EXPECT_EQ(wide[i].x, narrow[i].x);
    EXPECT_EQ(wide[i].y, narrow[i].y);
    EXPECT_EQ(wide[i].response, narrow[i].response);
  }
}

TEST(Harris, NoTextureGivesNoCorners) {
  test::Image image(320, 240);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{90});
  EXPECT_TRUE(detect(image).empty());
  // A ramp and a straight edge have gradients but no corner.
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) image.view().at(x, y) = static_cast<std::uint8_t>(x / 4 + (x > 160 ? 100 : 0));
  }
  EXPECT_TRUE(detect(image).empty());
}

TEST(Harris, CameraNoiseIsNotACorner) {
  test::Image image(320, 240);
  Rng rng(5);
  for (std::uint8_t& p : image.pixels) {
    double gaussian = -6;
    for (int k = 0; k < 12; ++k) gaussian += rng.uniform();
    p = static_cast<std::uint8_t>(std::floor(100.5 + 0.75 * gaussian));
  }
  EXPECT_LT(detect(image).size(), 20U);
}

TEST(Harris, KeepsItsPromisesOnNaturalTexture) {
  const test::Image image = test::render_texture(640, 480, {}, 1, 0, 2, 1);
  HarrisParams params;
  for (const std::int32_t target : {1, 50, 700, 2048}) {
    params.target_count = target;
    const Corners corners = detect(image, params);
    EXPECT_LE(corners.size(), static_cast<std::size_t>(target));
    if (target <= 700) {
      EXPECT_EQ(corners.size(), static_cast<std::size_t>(target));
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Corner& c = corners[i];
      EXPECT_TRUE(c.x >= 11.5F && c.y >= 11.5F && c.x <= 627.5F && c.y <= 467.5F);
      EXPECT_TRUE(c.response > 0 && c.response <= 1);
      for (std::size_t k = 0; k < i; ++k) {
        // The refinement may move both by half a pixel.
        EXPECT_GT(std::max(std::fabs(c.x - corners[k].x), std::fabs(c.y - corners[k].y)), 4.5F);
      }
    }
  }
}

TEST(Harris, SpreadsOverWeakAndStrongTexture) {
  // The left half has a fifth of the contrast: its responses are 600 times weaker.
  test::Image image = test::render_texture(640, 480, {}, 1, 0, 0, 1);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 320; ++x) {
      std::uint8_t& p = image.view().at(x, y);
      p = static_cast<std::uint8_t>(128 + (p - 128) / 5);
    }
  }
  HarrisParams params{.target_count = 600};
  const Corners corners = detect(image, params);
  const auto left = std::count_if(corners.begin(), corners.end(), [](const Corner& c) { return c.x < 320; });
  EXPECT_GT(left, 200);
  EXPECT_LT(left, 400);
}

TEST(Harris, FindsTheSameGroundPointsInATurnedImage) {
  const Similarity2 a{1, 0, 500, 500}, b{1.08, 0.4, 480, 330};
  const test::Image image_a = test::render_texture(640, 480, a, 1, 0, 1, 1);
  const test::Image image_b = test::render_texture(640, 480, b, 0.9, 8, 1, 2);
  const Similarity2 b_from_a = test::compose(test::inverse(b), a);
  const Corners corners_a = detect(image_a), corners_b = detect(image_b);
  int visible = 0, found = 0;
  for (const Corner& c : corners_a) {
    double x, y;
    test::apply(b_from_a, c.x, c.y, x, y);
    if (x < 14 || y < 14 || x > 625 || y > 465) continue;
    ++visible;
    found += std::any_of(corners_b.begin(), corners_b.end(),
                         [&](const Corner& d) { return std::hypot(d.x - x, d.y - y) < 1.5; })
                 ? 1
                 : 0;
  }
  EXPECT_GT(visible, 300);
  EXPECT_GT(found, visible / 2);
}

TEST(Harris, RefusesBadArguments) {
  const auto workspace = std::make_unique<HarrisWorkspace>();
  const test::Image image(100, 100);
  Corners corners;
  HarrisParams params{.target_count = static_cast<std::int32_t>(limits::max_corners) + 1};
  EXPECT_TRUE(detect_corners(image.view(), params, *workspace, corners).is(StatusCode::invalid_argument));
  params = {};
  params.min_distance_px = 1;
  EXPECT_TRUE(detect_corners(image.view(), params, *workspace, corners).is(StatusCode::invalid_argument));
  std::uint8_t pixel = 0;
  const GrayView huge(&pixel, limits::max_image_width + 1, limits::max_image_height);
  EXPECT_TRUE(detect_corners(huge, {}, *workspace, corners).is(StatusCode::image_too_large));
  // Too small for one corner is no error: there just is none.
  EXPECT_TRUE(detect_corners(test::Image(20, 20).view(), {}, *workspace, corners).ok());
  EXPECT_TRUE(corners.empty());
}

}  // namespace
}  // namespace ilp
