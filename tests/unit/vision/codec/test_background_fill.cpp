// What is put outside a region leaves the region alone and spares bytes.
#include <gtest/gtest.h>

#include <algorithm>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/background_fill.hpp"
#include "tests/unit/vision/codec/product_fixture.hpp"

namespace ilp {
namespace {

using namespace test;

struct Part {
  Part(std::int32_t w, std::int32_t h) : samples(w, h), mask(w, h) {}

  Decoded samples;
  Mask mask;
};

/// One sample in `rarity` is inside.
Part random_part(std::int32_t w, std::int32_t h, std::uint32_t rarity, Rng& rng) {
  Part part(w, h);
  for (std::size_t i = 0; i < part.samples.pixels.size(); ++i) {
    part.samples.pixels[i] = static_cast<std::int32_t>(rng.below(9000)) - 4000;
    part.mask.pixels[i] = rng.below(rarity) == 0 ? 1 : 0;
  }
  return part;
}

void fill(const Mask& mask, Decoded& samples) {
  static std::vector<std::int32_t> scratch(limits::max_image_pixels);
  fill_background({samples.pixels.data(), mask.view().width, mask.view().height}, mask.view(), scratch.data());
}

TEST(BackgroundFill, KeepsTheInsideAndStaysBetweenItsExtremes) {
  Rng rng(5);
  for (int trial = 0; trial < 200; ++trial) {
    const auto w = static_cast<std::int32_t>(1 + rng.below(70)), h = static_cast<std::int32_t>(1 + rng.below(70));
    auto [samples, mask] = random_part(w, h, 1 + rng.below(200), rng);
    std::int32_t lowest = 1 << 30, highest = -(1 << 30);
    for (std::size_t i = 0; i < samples.pixels.size(); ++i) {
      if (mask.pixels[i] == 0) continue;
      lowest = std::min(lowest, samples.pixels[i]);
      highest = std::max(highest, samples.pixels[i]);
    }
    const Decoded before = samples;
    fill(mask, samples);
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
  for (int trial = 0; trial < 200; ++trial) {
    const auto w = static_cast<std::int32_t>(1 + rng.below(90)), h = static_cast<std::int32_t>(1 + rng.below(40));
    auto [narrow, mask] = random_part(w, h, 1 + rng.below(20), rng);
    Decoded wide = narrow;
    use_vectors(VectorWidth::bytes16);
    fill(mask, narrow);
    use_vectors(widest_vectors());
    fill(mask, wide);
    ASSERT_EQ(narrow.pixels, wide.pixels) << w << " x " << h;
  }
}

// With a power of two no level has a last column or row without a partner.
TEST(BackgroundFill, AMirroredPartIsFilledAsTheMirroredOne) {
  constexpr std::int32_t side = 64;
  Rng rng(11);
  for (int trial = 0; trial < 20; ++trial) {
    auto [samples, mask] = random_part(side, side, 1 + rng.below(50), rng);
    const auto mirrored = [](const auto& image) {
      auto result = image;
      for (std::size_t y = 0; y < side; ++y) {
        std::reverse(result.pixels.begin() + side * static_cast<std::ptrdiff_t>(y),
                     result.pixels.begin() + side * static_cast<std::ptrdiff_t>(y + 1));
      }
      return result;
    };
    const auto turned = [](const auto& image) {
      auto result = image;
      std::reverse(result.pixels.begin(), result.pixels.end());
      return result;
    };
    Decoded across = mirrored(samples), around = turned(samples);
    fill(mirrored(mask), across);
    fill(turned(mask), around);
    fill(mask, samples);
    EXPECT_EQ(mirrored(across).pixels, samples.pixels);
    EXPECT_EQ(turned(around).pixels, samples.pixels);
  }
}

TEST(BackgroundFill, AConstantStaysAConstant) {
  Decoded samples(97, 61);
  const Mask mask = disc_mask(97, 61, 0.1);
  for (std::size_t i = 0; i < samples.pixels.size(); ++i) samples.pixels[i] = mask.pixels[i] != 0 ? 1234 : -77;
  fill(mask, samples);
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
