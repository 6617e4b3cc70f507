// What products promise over masks of 5 to 100 % and 0.1 to 4 bit per pixel, on rendered and recorded images.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "fsw/base/rng.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "tests/unit/vision/codec/product_fixture.hpp"

namespace ilp {
namespace {

using namespace test;

std::vector<std::pair<std::string, Image>> rendered_and_recorded() {
  std::vector<std::pair<std::string, Image>> images;
  images.emplace_back("rendered", detailed_image(320, 240));
  images.emplace_back("rendered with noise", textured_image(320, 240));
  for (const char* strip : {"aerial_caliterra_a", "aerial_coal_oil_point"}) {
    const auto views = read_strip(strip);
    if (views.empty()) continue;
    Image image = read_strip_image(strip, views[0].name);
    if (image.width > limits::max_image_side || image.height > limits::max_image_side) continue;
    images.emplace_back(strip, std::move(image));
  }
  return images;
}

class ProductBarsTest : public Jpeg2000Test {};

TEST_F(ProductBarsTest, MoreBytesNeverLookWorseInsideAndNeverOneTooMany) {
  for (const auto& [name, image] : rendered_and_recorded()) {
    for (const double share : {0.05, 0.33, 0.66, 1.0}) {
      const Mask mask = disc_mask(image.width, image.height, share);
      double before = 0;
      for (const double bpp : {0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.4, 2.0, 2.8, 4.0}) {
        SCOPED_TRACE(name + ", share " + std::to_string(share) + ", " + std::to_string(bpp) + " bpp");
        Jpeg2000Params params{.max_bytes = bytes_for(bpp, image.view()), .layers = 4};
        const Status status = encode(image.view(), mask.view(), params);
        ASSERT_TRUE(status.ok()) << status_name(status.code);
        ASSERT_LE(product.bytes, params.max_bytes);
        LayerErrors errors;
        ASSERT_TRUE(measure_layer_errors(bytes(), image.view(), mask.view(), errors).ok());
        double layer_before = 0;
        for (int i = 0; i < errors.layers; ++i) {
          const double quality = psnr_of(errors.mean_square[static_cast<std::size_t>(i)]);
          EXPECT_GE(quality, layer_before - 0.1) << "layer " << i + 1;
          layer_before = quality;
        }
        EXPECT_GE(layer_before, before - 0.1);
        before = layer_before;
      }
    }
  }
}

// Where everything does not fit, the region still does.
TEST_F(ProductBarsTest, ALosslessRegionIsExactWithWhatBytesThereAre) {
  for (const auto& [name, image] : rendered_and_recorded()) {
    for (const double share : {0.05, 0.33}) {
      SCOPED_TRACE(name + ", share " + std::to_string(share));
      const Mask mask = disc_mask(image.width, image.height, share);
      Jpeg2000Params params{
          .max_bytes = file.size(), .region = RegionCoding::drop_background, .layers = 4, .lossless = true};
      ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
      const std::size_t region_bytes = product.bytes;
      params.region = RegionCoding::shift;
      params.max_bytes = file.size();
      ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
      const std::size_t all_bytes = product.bytes;
      for (const std::size_t grant :
           {region_bytes, region_bytes * 11 / 10, all_bytes * 19 / 20, all_bytes * 99 / 100}) {
        params.max_bytes = grant;
        const Status status = encode(image.view(), mask.view(), params);
        ASSERT_TRUE(status.ok()) << status_name(status.code) << " at " << grant;
        ASSERT_LE(product.bytes, grant);
        const Decoded decoded = decode();
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
          if (mask.pixels[i] != 0) {
            ASSERT_EQ(decoded.pixels[i], image.pixels[i]);
          }
        }
      }
    }
  }
}

TEST_F(ProductBarsTest, ConstantImagesAndNoiseTakeAnyGrant) {
  Image noise = textured_image(130, 101);
  Rng rng(12);
  for (auto& p : noise.pixels) p = static_cast<std::uint8_t>(rng.below(256));
  Image constant = noise;
  for (auto& p : constant.pixels) p = 255;
  for (const Image* image : {&noise, &constant}) {
    for (const double share : {0.0, 0.3, 1.0}) {
      const Mask mask = disc_mask(130, 101, share);
      for (const std::size_t grant : {0U, 100U, 230U, 300U, 500U, 1000U, 3000U, 10000U, 30000U, 1U << 20U, 1U << 31U}) {
        for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift, RegionCoding::drop_background}) {
          Jpeg2000Params params{.max_bytes = grant, .region = coding, .layers = 8};
          const Status status = encode(image->view(), mask.view(), params);
          if (!status.ok()) {
            ASSERT_TRUE(status.is(StatusCode::grant_too_small)) << status_name(status.code);
            EXPECT_LT(grant, 1000U);
            continue;
          }
          ASSERT_LE(product.bytes, grant);
          const Decoded decoded = decode();
          if (grant < 30000) continue;
          const bool all = coding == RegionCoding::none;
          for (std::size_t i = 0; i < image->pixels.size(); ++i) {
            if (all || mask.pixels[i] != 0) {
              ASSERT_EQ(decoded.pixels[i], image->pixels[i]);
            }
          }
        }
      }
    }
  }
}

/// Products with a shift, a dropped background and cut layers go through `command IN.jp2 OUT.pgm` and come back as our
/// decoder reads them.
class OtherDecodersTest : public Jpeg2000Test {
 protected:
  void expect_agreement(const std::string& before, const std::string& between, const std::string& after) {
    const std::string stem = ::testing::TempDir() + "ilp_other_" + std::to_string(getpid());
    const Image image = textured_image(161, 120);
    const Mask mask = disc_mask(161, 120, 0.3);
    metadata.assign(100, 'x');
    for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift, RegionCoding::drop_background}) {
      for (const std::size_t grant : {std::size_t{3000}, std::size_t{12000}, file.size()}) {
        Jpeg2000Params params{.max_bytes = grant, .region = coding, .layers = 3};
        ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
        if (grant == 3000) {
          ASSERT_TRUE(truncate_to_layers(std::span(file).first(product.bytes), 1, product.bytes).ok());
        }
        std::ofstream(stem + ".jp2", std::ios::binary)
            .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(product.bytes));
        std::string command = before;
        command.append(stem).append(".jp2").append(between).append(stem).append(".pgm").append(after);
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
        EXPECT_EQ(read_pgm(stem + ".pgm").samples.pixels, decode().pixels) << command;
      }
    }
    for (const char* suffix : {".jp2", ".pgm", ".pgm.aux.xml"}) std::remove((stem + suffix).c_str());
  }
};

TEST_F(OtherDecodersTest, GdalReadsTheSameSamples) {
  if (std::system("gdal_translate --formats 2>/dev/null | grep -q JP2OpenJPEG") != 0) {
    GTEST_SKIP() << "gdal_translate with JPEG 2000 is not installed";
  }
  expect_agreement("gdal_translate -q -of PNM ", " ", " > /dev/null 2>&1");
}

TEST_F(OtherDecodersTest, GrokReadsTheSameSamples) {
  if (std::system("command -v grk_decompress > /dev/null 2>&1") != 0) {
    GTEST_SKIP() << "grk_decompress (Grok) is not installed";
  }
  expect_agreement("grk_decompress -i ", " -o ", " > /dev/null 2>&1");
}

}  // namespace
}  // namespace ilp
