// Views address the pixels that they claim to, and images refuse what is larger than they are.
#include "fsw/base/image_view.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace ilp {
namespace {

TEST(ImageView, StrideSeparatesRows) {
  std::uint8_t pixels[4 * 6] = {};
  for (int i = 0; i < 24; ++i) pixels[i] = static_cast<std::uint8_t>(i);
  const MutableGrayView view(pixels, 5, 4, 6);
  EXPECT_EQ(view.at(0, 0), 0);
  EXPECT_EQ(view.at(4, 0), 4);
  EXPECT_EQ(view.at(0, 1), 6);
  EXPECT_EQ(view.row(3)[2], 20);
  view.at(1, 2) = 200;
  EXPECT_EQ(pixels[13], 200);
  EXPECT_EQ(view.area(), 20U);
}

TEST(ImageView, CropIsAWindowOnTheSamePixels) {
  std::uint8_t pixels[36] = {};
  for (int i = 0; i < 36; ++i) pixels[i] = static_cast<std::uint8_t>(i);
  const MutableGrayView whole(pixels, 6, 6);
  const MutableGrayView part = whole.crop(2, 1, 3, 4);
  EXPECT_EQ(part.width, 3);
  EXPECT_EQ(part.height, 4);
  EXPECT_EQ(part.at(0, 0), 8);
  EXPECT_EQ(part.at(2, 3), 28);
  const MutableGrayView inner = part.crop(1, 1, 1, 1);
  EXPECT_EQ(inner.at(0, 0), 15);
}

TEST(ImageView, ContainsExactlyItsPixels) {
  std::uint8_t pixels[6] = {};
  const GrayView view(pixels, 3, 2);
  EXPECT_TRUE(view.contains(0, 0));
  EXPECT_TRUE(view.contains(2, 1));
  EXPECT_FALSE(view.contains(3, 1));
  EXPECT_FALSE(view.contains(2, 2));
  EXPECT_FALSE(view.contains(-1, 0));
  EXPECT_FALSE(view.empty());
  EXPECT_TRUE(GrayView().empty());
}

TEST(ImageView, MutableConvertsToConstantOnly) {
  static_assert(std::is_convertible_v<MutableGrayView, GrayView>);
  static_assert(!std::is_convertible_v<GrayView, MutableGrayView>);
  std::uint8_t pixel = 9;
  const GrayView view = MutableGrayView(&pixel, 1, 1);
  EXPECT_EQ(view.at(0, 0), 9);
}

TEST(FixedImage, RefusesWhatDoesNotFit) {
  FixedImage<std::uint16_t, 12> image;
  EXPECT_TRUE(image.resize(4, 3).ok());
  EXPECT_EQ(image.view().width, 4);
  EXPECT_EQ(image.view().stride, 4);
  image.view().at(3, 2) = 77;
  const auto& constant = image;
  EXPECT_EQ(constant.view().at(3, 2), 77);
  const Status refused = image.resize(13, 1);
  EXPECT_TRUE(refused.is(StatusCode::image_too_large));
  EXPECT_EQ(refused.a, 13);
  EXPECT_FALSE(image.resize(-1, 3).ok());
  // 65536 * 65536 would be 0 in 32 bits.
  EXPECT_FALSE(image.resize(65536, 65536).ok());
  EXPECT_EQ(image.width(), 4);
  EXPECT_EQ(image.height(), 3);
}

}  // namespace
}  // namespace ilp
