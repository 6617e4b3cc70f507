// What is put outside a region leaves the region alone and spares bytes.
#include <gtest/gtest.h>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/background_fill.hpp"
#include "tests/unit/vision/codec/product_fixture.hpp"

namespace ilp {
namespace {

using namespace test;

TEST(BackgroundFill, KeepsTheInsideAndStaysBetweenItsExtremes) {
  Rng rng(5);
  std::vector<std::int32_t> scratch(limits::max_image_pixels);
  for (int trial = 0; trial < 200; ++trial) {
    const auto w = static_cast<std::int32_t>(1 + rng.below(70)), h = static_cast<std::int32_t>(1 + rng.below(70));
    Decoded samples(w, h);
    Mask mask(w, h);
    const std::uint32_t rarity = 1 + rng.below(200);
    std::int32_t lowest = 1 << 30, highest = -(1 << 30);
    for (std::size_t i = 0; i < samples.pixels.size(); ++i) {
      samples.pixels[i] = static_cast<std::int32_t>(rng.below(9000)) - 4000;
      mask.pixels[i] = rng.below(rarity) == 0 ? 1 : 0;
      if (mask.pixels[i] == 0) continue;
      lowest = std::min(lowest, samples.pixels[i]);
      highest = std::max(highest, samples.pixels[i]);
    }
    const Decoded before = samples;
    fill_background({samples.pixels.data(), w, h}, mask.view(), scratch.data());
    for (std::size_t i = 0; i < samples.pixels.size(); ++i) {
      if (mask.pixels[i] != 0 || lowest > highest) {
        ASSERT_EQ(samples.pixels[i], before.pixels[i]);
      } else {
        ASSERT_GE(samples.pixels[i], lowest - 1);
        ASSERT_LE(samples.pixels[i], highest + 1);
      }
    }
  }
}

// Every other size has a last column or row without a partner.
TEST(BackgroundFill, VectorsOfBothWidthsFillTheSame) {
  Rng rng(7);
  std::vector<std::int32_t> scratch(limits::max_image_pixels);
  for (int trial = 0; trial < 200; ++trial) {
    const auto w = static_cast<std::int32_t>(1 + rng.below(90)), h = static_cast<std::int32_t>(1 + rng.below(40));
    Decoded narrow(w, h);
    Mask mask(w, h);
    const std::uint32_t rarity = 1 + rng.below(20);
    for (std::size_t i = 0; i < narrow.pixels.size(); ++i) {
      narrow.pixels[i] = static_cast<std::int32_t>(rng.below(9000)) - 4000;
      mask.pixels[i] = rng.below(rarity) == 0 ? 1 : 0;
    }
    Decoded wide = narrow;
    use_vectors(VectorWidth::bytes16);
    fill_background({narrow.pixels.data(), w, h}, mask.view(), scratch.data());
    use_vectors(widest_vectors());
    fill_background({wide.pixels.data(), w, h}, mask.view(), scratch.data());
    ASSERT_EQ(narrow.pixels, wide.pixels) << w << " x " << h;
  }
}

TEST(BackgroundFill, AConstantStaysAConstant) {
  Decoded samples(97, 61);
  const Mask mask = disc_mask(97, 61, 0.1);
  for (std::size_t i = 0; i < samples.pixels.size(); ++i) samples.pixels[i] = mask.pixels[i] != 0 ? 1234 : -77;
  std::vector<std::int32_t> scratch(limits::max_image_pixels);
  fill_background({samples.pixels.data(), 97, 61}, mask.view(), scratch.data());
  for (const std::int32_t v : samples.pixels) ASSERT_EQ(v, 1234);
}

// A depth map is 0 outside its mask: that cliff is worth no bytes.
TEST_F(Jpeg2000Test, TheCliffAroundADepthMapCostsNoBytes) {
  Depth hills = depth_map(320, 240, 13);
  const Mask mask = disc_mask(320, 240, 0.25);
  Depth cliff = hills;
  for (std::size_t i = 0; i < cliff.pixels.size(); ++i) cliff.pixels[i] = mask.pixels[i] != 0 ? hills.pixels[i] : 0;
  Jpeg2000Params params;
  params.max_bytes = file.size();
  params.lossless = true;
  params.region = RegionCoding::drop_background;
  params.region_resolutions = 1;
  ASSERT_TRUE(encode(cliff, 13, mask.view(), params).ok());
  const std::size_t with_cliff = product.bytes;
  params.region_resolutions = 0;
  ASSERT_TRUE(encode(cliff, 13, mask.view(), params).ok());
  EXPECT_LT(product.bytes, with_cliff * 17 / 20);
  const Decoded decoded = decode();
  for (std::size_t i = 0; i < hills.pixels.size(); ++i) {
    if (mask.pixels[i] != 0) {
      ASSERT_EQ(decoded.pixels[i], hills.pixels[i]);
    }
  }
}

}  // namespace
}  // namespace ilp
