// What is said of a product's layers holds for what any decoder makes of them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "tests/unit/vision/codec/product_fixture.hpp"

namespace ilp {
namespace {

using namespace test;

class LayerErrorsTest : public Jpeg2000Test {
 protected:
  [[nodiscard]] std::vector<std::uint8_t> cut(int layers) const {
    std::vector<std::uint8_t> copy(bytes().begin(), bytes().end());
    std::size_t size = 0;
    EXPECT_TRUE(truncate_to_layers(copy, layers, size).ok());
    copy.resize(size);
    return copy;
  }

  LayerErrors errors;
};

template <typename Pixel>
void expect_errors(ImageView<const Pixel> original, const Decoded& decoded, MaskView mask, std::int32_t largest,
                   double mean_square) {
  std::int32_t worst = 0;
  double sum = 0, count = 0;
  for (std::int32_t y = 0; y < original.height; ++y) {
    for (std::int32_t x = 0; x < original.width; ++x) {
      if (mask.data != nullptr && mask.at(x, y) == 0) continue;
      const std::int32_t e = std::abs(decoded.view().at(x, y) - static_cast<std::int32_t>(original.at(x, y)));
      worst = std::max(worst, e);
      sum += static_cast<double>(e) * e;
      ++count;
    }
  }
  EXPECT_EQ(worst, largest);
  EXPECT_NEAR(count > 0 ? sum / count : 0, mean_square, 1e-9 * (1 + sum));
}

TEST_F(LayerErrorsTest, AreThoseOfTheFileCutThere) {
  const Image image = textured_image(221, 167);
  for (const double share : {0.0, 0.2, 1.0}) {
    const Mask mask = disc_mask(221, 167, share);
    for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift, RegionCoding::drop_background}) {
      for (const std::size_t ceiling : {std::size_t{1500}, std::size_t{9000}, file.size()}) {
        Jpeg2000Params params{.max_bytes = ceiling, .region = coding, .layers = 4};
        ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
        ASSERT_TRUE(measure_layer_errors(bytes(), image.view(), mask.view(), errors).ok());
        ASSERT_EQ(errors.layers, product.layers);
        for (int layers = 1; layers <= product.layers; ++layers) {
          const auto i = static_cast<std::size_t>(layers - 1);
          expect_errors<std::uint8_t>(image.view(), decode(cut(layers)), mask.view(), errors.largest[i],
                                      errors.mean_square[i]);
        }
        LayerErrors narrow;
        use_vectors(VectorWidth::bytes16);
        ASSERT_TRUE(measure_layer_errors(bytes(), image.view(), mask.view(), narrow).ok());
        use_vectors(widest_vectors());
        EXPECT_EQ(narrow.largest, errors.largest);
        EXPECT_EQ(narrow.mean_square, errors.mean_square);
      }
    }
  }
}

Mask special_mask(int kind, std::int32_t width, std::int32_t height) {
  Mask mask(width, height);
  Rng rng(7);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const bool in[] = {false, true, x == 31 && y == 17, (x + y) % 2 == 0, y == height / 2, x == 0, rng.below(9) == 0};
      mask.at(x, y) = in[kind] ? 255 : 0;
    }
  }
  return mask;
}

// The stated bound is the largest error; a decoder of other people measures it.
TEST_F(LayerErrorsTest, NoPixelOfADepthMapIsWorseThanStated) {
  const bool has_decoder = std::system("command -v opj_decompress > /dev/null 2>&1") == 0;
  const std::string stem = ::testing::TempDir() + "ilp_depth_" + std::to_string(getpid());
  const Depth hills = depth_map(150, 110, 13);
  Depth noise(150, 110);
  Rng rng(3);
  for (auto& v : noise.pixels) v = static_cast<std::uint16_t>(1 + rng.below(8191));
  for (const Depth& depth : {hills, noise}) {
    for (int kind = 0; kind < 7; ++kind) {
      const Mask mask = special_mask(kind, 150, 110);
      for (const std::size_t grant : {400U, 700U, 1500U, 4000U, 12000U, 60000U}) {
        SCOPED_TRACE("mask " + std::to_string(kind) + ", grant " + std::to_string(grant));
        Jpeg2000Params params{
            .max_bytes = grant, .region = RegionCoding::drop_background, .region_resolutions = 0, .layers = 4};
        const Status status = encode(depth, 13, mask.view(), params);
        ASSERT_TRUE(status.ok()) << status_name(status.code);
        ASSERT_LE(product.bytes, grant);
        ASSERT_TRUE(measure_layer_errors(bytes(), depth.view(), mask.view(), errors).ok());
        for (int layers = 1; layers <= product.layers; ++layers) {
          const auto i = static_cast<std::size_t>(layers - 1);
          const std::vector<std::uint8_t> part = cut(layers);
          Decoded decoded = decode(part);
          if (has_decoder && grant == 1500) {
            std::ofstream(stem + ".jp2", std::ios::binary)
                .write(reinterpret_cast<const char*>(part.data()), static_cast<std::streamsize>(part.size()));
            const std::string command = "opj_decompress -i " + stem + ".jp2 -o " + stem + ".pgm > /dev/null 2>&1";
            ASSERT_EQ(std::system(command.c_str()), 0) << command;
            decoded = read_pgm(stem + ".pgm").samples;
          }
          expect_errors<std::uint16_t>(depth.view(), decoded, mask.view(), errors.largest[i], errors.mean_square[i]);
        }
        const std::int32_t last = errors.largest[static_cast<std::size_t>(errors.layers - 1)];
        if (grant == 60000) {
          EXPECT_EQ(last, 0) << "all bytes that it takes";
        }
      }
    }
  }
  for (const char* suffix : {".jp2", ".pgm"}) std::remove((stem + suffix).c_str());
}

TEST_F(LayerErrorsTest, LayersAfterOneThatIsGoodEnoughAreNotMeasured) {
  const Depth depth = depth_map(150, 110, 13);
  const Mask mask = disc_mask(150, 110, 0.5);
  Jpeg2000Params params{.max_bytes = file.size(), .region = RegionCoding::drop_background, .layers = 4};
  ASSERT_TRUE(encode(depth, 13, mask.view(), params).ok());
  ASSERT_EQ(product.layers, 4);
  LayerErrors all;
  ASSERT_TRUE(measure_layer_errors(bytes(), depth.view(), mask.view(), all).ok());
  ASSERT_GT(all.largest[0], all.largest[1]);
  ASSERT_GT(all.largest[1], all.largest[2]);
  for (int enough = 0; enough < 4; ++enough) {
    const std::int32_t error = all.largest[static_cast<std::size_t>(enough)];
    ASSERT_TRUE(measure_layer_errors(bytes(), depth.view(), mask.view(), errors, error).ok());
    EXPECT_EQ(errors.layers, enough + 1);
    for (std::size_t i = 0; i <= static_cast<std::size_t>(enough); ++i) EXPECT_EQ(errors.largest[i], all.largest[i]);
  }
}

TEST_F(LayerErrorsTest, TheSmallestDepthMapsHaveTheirBoundsToo) {
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 9}, {7, 1}, {2, 2}, {3, 5}, {17, 2}}) {
    const Depth depth = depth_map(w, h, 13);
    for (const double share : {0.0, 0.4, 1.0}) {
      const Mask mask = disc_mask(w, h, share);
      Jpeg2000Params params{
          .max_bytes = file.size(), .region = RegionCoding::drop_background, .region_resolutions = 0, .layers = 4};
      ASSERT_TRUE(encode(depth, 13, mask.view(), params).ok()) << w << "x" << h;
      ASSERT_TRUE(measure_layer_errors(bytes(), depth.view(), mask.view(), errors).ok());
      EXPECT_EQ(errors.largest[static_cast<std::size_t>(errors.layers - 1)], 0) << w << "x" << h << " " << share;
      expect_errors<std::uint16_t>(depth.view(), decode(), mask.view(), 0, 0);
    }
  }
}

TEST_F(LayerErrorsTest, PsnrIsOfTheMeanSquareAndFiniteWhenExact) {
  EXPECT_NEAR(psnr_of(1), 48.1308, 1e-4);
  EXPECT_NEAR(psnr_of(255.0 * 255.0), 0, 1e-9);
  EXPECT_EQ(psnr_of(0), exact_psnr_db);
  EXPECT_LT(psnr_of(1.0 / static_cast<double>(limits::max_image_pixels)), exact_psnr_db);
}

TEST_F(LayerErrorsTest, OtherSizesAndOtherFilesAreRefused) {
  const Image image = textured_image(64, 48);
  const Image other = textured_image(64, 49);
  Jpeg2000Params params{.max_bytes = 4000};
  ASSERT_TRUE(encode(image.view(), {}, params).ok());
  EXPECT_TRUE(measure_layer_errors(bytes(), other.view(), {}, errors).is(StatusCode::invalid_argument));
  const Mask mask = disc_mask(64, 49, 0.5);
  EXPECT_TRUE(measure_layer_errors(bytes(), image.view(), mask.view(), errors).is(StatusCode::invalid_argument));
  EXPECT_FALSE(measure_layer_errors(bytes().first(40), image.view(), {}, errors).ok());
  EXPECT_FALSE(measure_layer_errors(bytes().first(product.bytes / 2), image.view(), {}, errors).ok());
}

}  // namespace
}  // namespace ilp
