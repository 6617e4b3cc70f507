#include <gtest/gtest.h>

#include <memory>

#include "fsw/base/rng.hpp"
#include "fsw/vision/image/box_sums.hpp"
#include "fsw/vision/image/pyramid.hpp"
#include "fsw/vision/image/sampling.hpp"
#include "tests/support/read_image.hpp"

namespace ilp {
namespace {

TEST(Pyramid, AveragesFourPixelsRoundedToNearest) {
  test::Image image(4, 2);
  image.pixels = {10, 11, 0, 255, 12, 13, 255, 0};
  test::Image half(2, 1);
  halve(image.view(), half.view());
  EXPECT_EQ(half.pixels[0], 12);   // 46 / 4 = 11.5
  EXPECT_EQ(half.pixels[1], 128);  // 510 / 4 = 127.5
}

TEST(Pyramid, HalvesUntilTheLongerSideIsSmallEnough) {
  const auto pyramid = std::make_unique<Pyramid>();
  test::Image image(321, 163);
  ASSERT_TRUE(pyramid->build(image.view(), 48).ok());
  ASSERT_EQ(pyramid->levels(), 4);
  EXPECT_EQ(pyramid->level(0).data, image.pixels.data());
  EXPECT_EQ(pyramid->level(1).width, 160);
  EXPECT_EQ(pyramid->level(1).height, 81);
  EXPECT_EQ(pyramid->level(3).width, 40);
  EXPECT_EQ(pyramid->level(3).height, 20);
}

TEST(Pyramid, LevelsShowWhatTheirPixelsCover) {
  // A ramp: the mean of any box is the value at its centre, so the documented position of a coarse pixel can be
  // checked.
  const auto pyramid = std::make_unique<Pyramid>();
  test::Image image(96, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) image.view().at(x, y) = static_cast<std::uint8_t>(2 * x + y);
  }
  ASSERT_TRUE(pyramid->build(image.view(), 24).ok());
  ASSERT_EQ(pyramid->levels(), 3);
  const double x = (5 + 0.5) * 4 - 0.5, y = (7 + 0.5) * 4 - 0.5;
  EXPECT_NEAR(pyramid->level(2).at(5, 7), 2 * x + y, 1.0);
}

TEST(Pyramid, RefusesWhatDoesNotFit) {
  const auto pyramid = std::make_unique<Pyramid>();
  std::uint8_t pixel = 0;
  const GrayView huge(&pixel, limits::max_image_width + 1, limits::max_image_height);
  EXPECT_TRUE(pyramid->build(huge, 48).is(StatusCode::image_too_large));
  EXPECT_TRUE(pyramid->build(GrayView{}, 48).is(StatusCode::invalid_argument));
}

TEST(BoxSums, EqualTheDirectSum) {
  constexpr int w = 17, h = 11;
  std::uint8_t values[w * h];
  std::int32_t sums[(w + 1) * (h + 1)];
  Rng rng(3);
  for (std::uint8_t& v : values) v = static_cast<std::uint8_t>(rng.below(256));
  integrate<std::uint8_t, std::int32_t>({values, w, h}, {sums, w + 1, h + 1});
  for (int k = 0; k < 50; ++k) {
    const int x0 = static_cast<int>(rng.below(w)), y0 = static_cast<int>(rng.below(h));
    const int x1 = x0 + static_cast<int>(rng.below(static_cast<std::uint32_t>(w - x0 + 1)));
    const int y1 = y0 + static_cast<int>(rng.below(static_cast<std::uint32_t>(h - y0 + 1)));
    int expected = 0;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) expected += values[y * w + x];
    }
    EXPECT_EQ(box_sum(ImageView<std::int32_t>(sums, w + 1, h + 1), x0, y0, x1, y1), expected);
  }
}

TEST(Sampling, IsNearestOnABilinearSurface) {
  test::Image image(8, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) image.view().at(x, y) = static_cast<std::uint8_t>(10 + 7 * x + 3 * y + 2 * x * y);
  }
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {2.25, 3.5}, {6.75, 6.125}}) {
    const double expected = 10 + 7 * x + 3 * y + 2 * x * y;
    // Between pixels 2xy is bilinear too, so the eight-bit weights lose nothing.
    EXPECT_EQ(sample_bilinear(image.view(), to_fixed(x), to_fixed(y)), std::lround(expected));
  }
}

}  // namespace
}  // namespace ilp
