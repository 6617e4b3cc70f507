// Products: exactness, byte ceiling, region of interest, layers, what another decoder makes of them, hostile input.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "tests/support/read_image.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/vision/codec/product_fixture.hpp"

extern "C" double opj_dwt_getnorm(std::uint32_t level, std::uint32_t orientation);

namespace ilp {
namespace {

using namespace test;

/// Norm of what a coefficient becomes when it is transformed back by the 5/3 filters, in one direction.
double norm_of_coefficient(bool high, int levels) {
  std::vector<double> values = {1};
  for (int level = 0; level < levels; ++level) {
    const std::vector<double> filter =
        high && level == 0 ? std::vector<double>{-0.125, -0.25, 0.75, -0.25, -0.125} : std::vector<double>{0.5, 1, 0.5};
    std::vector<double> finer(2 * values.size() + filter.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t k = 0; k < filter.size(); ++k) finer[2 * i + k] += values[i] * filter[k];
    }
    values = finer;
  }
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum);
}

TEST(RateControl, NormsAreThoseOfTheTransformAndTheirProductsAreExact) {
  constexpr double largest_sum = 2147483647;
  for (std::uint32_t orientation = 0; orientation < 4; ++orientation) {
    // Level 0 of the low band is the image, of the others the finest.
    for (std::uint32_t level = 0; level < 6; ++level) {
      const int levels = static_cast<int>(level) + (orientation > 0 ? 1 : 0);
      const double expected =
          norm_of_coefficient((orientation & 1U) != 0, levels) * norm_of_coefficient((orientation & 2U) != 0, levels);
      const double norm = opj_dwt_getnorm(level, orientation);
      EXPECT_NEAR(norm / expected, 1, 1e-3) << orientation << " " << level;
      const double weighted = norm * largest_sum;
      EXPECT_EQ(std::fma(norm, weighted, -(norm * weighted)), 0) << orientation << " " << level;
    }
  }
}

TEST_F(Jpeg2000Test, LosslessIsExactForEverySizeAndRegionCoding) {
  for (const auto& [w, h] :
       {std::pair{1, 1}, {1, 7}, {5, 1}, {2, 2}, {3, 17}, {33, 64}, {65, 63}, {200, 131}, {300, 2}}) {
    const Image image = textured_image(w, h);
    const Mask mask = disc_mask(w, h, 0.3);
    for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift}) {
      Jpeg2000Params params{.max_bytes = file.size(), .region = coding, .lossless = true};
      const Status status = encode(image.view(), mask.view(), params);
      ASSERT_TRUE(status.ok()) << w << "x" << h << " " << status_name(status.code) << " " << status.b;
      const Decoded decoded = decode();
      for (std::size_t i = 0; i < image.pixels.size(); ++i) ASSERT_EQ(decoded.pixels[i], image.pixels[i]);
    }
  }
}

TEST_F(Jpeg2000Test, DepthIsExactInsideTheMaskWithTheBackgroundDropped) {
  for (const int bits : {1, 8, 13, 16}) {
    const Depth depth = depth_map(240, 180, bits);
    const Mask mask = disc_mask(240, 180, 0.2);
    Jpeg2000Params params;
    params.max_bytes = file.size();
    params.lossless = true;
    params.region = RegionCoding::drop_background;
    params.region_resolutions = 0;
    params.layers = 3;
    ASSERT_TRUE(encode(depth, bits, mask.view(), params).ok()) << bits;
    const std::size_t masked = product.bytes;
    const Decoded decoded = decode();
    for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
      if (mask.pixels[i] == 0) continue;
      ASSERT_EQ(decoded.pixels[i], depth.pixels[i]) << bits << " bits, pixel " << i;
    }
    params.region = RegionCoding::none;
    ASSERT_TRUE(encode(depth, bits, mask.view(), params).ok());
    if (bits != 13) continue;
    EXPECT_LT(masked, product.bytes / 2) << "what is dropped must not cost bytes";
  }
}

TEST_F(Jpeg2000Test, NeverOneByteOverTheCeiling) {
  const Image image = textured_image(256, 192);
  metadata.assign(300, 'm');
  for (const double share : {0.05, 0.33, 1.0}) {
    const Mask mask = disc_mask(256, 192, share);
    for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift, RegionCoding::drop_background}) {
      for (const int layers : {1, 5}) {
        for (const double bpp : {0.1, 0.2, 0.35, 0.5, 1.0, 1.7, 2.5, 4.0}) {
          Jpeg2000Params params{.max_bytes = bytes_for(bpp, image.view()), .region = coding, .layers = layers};
          // What lies beyond the ceiling must stay untouched.
          std::fill(file.begin(), file.end(), std::uint8_t{0xa5});
          const Status status = encode(image.view(), mask.view(), params);
          ASSERT_TRUE(status.ok()) << status_name(status.code) << " " << bpp << " bpp, share " << share;
          ASSERT_LE(product.bytes, params.max_bytes);
          for (std::size_t i = params.max_bytes; i < file.size(); ++i) ASSERT_EQ(file[i], 0xa5);
          const Decoded decoded = decode();
          if (share == 1.0 && bpp == 1.0) {
            EXPECT_GE(product.bytes, params.max_bytes * 93 / 100) << "the grant should be used";
            EXPECT_GT(psnr(image.view(), decoded, mask.view(), true), 28);
          }
        }
      }
    }
  }
}

TEST_F(Jpeg2000Test, SmallGrantsAreKeptOrRefused) {
  const Image image = textured_image(320, 240);
  const Mask mask = disc_mask(320, 240, 0.3);
  std::size_t smallest_done = 0;
  for (std::size_t grant = 0; grant < 1500; grant += 23) {
    Jpeg2000Params params{.max_bytes = grant, .layers = 4};
    const Status status = encode(image.view(), mask.view(), params);
    if (status.ok()) {
      ASSERT_LE(product.bytes, grant);
      EXPECT_EQ(decode().width, 320);
      if (smallest_done == 0) smallest_done = grant;
    } else {
      ASSERT_TRUE(status.is(StatusCode::grant_too_small)) << status_name(status.code) << " at " << grant;
      EXPECT_EQ(status.a, static_cast<std::int64_t>(grant));
      EXPECT_GT(status.b, status.a);
    }
  }
  EXPECT_GT(smallest_done, 0U);
  EXPECT_LT(smallest_done, 500U);
}

TEST_F(Jpeg2000Test, LosslessThatDoesNotFitSaysWhatItNeeds) {
  const Image image = textured_image(160, 120);
  Jpeg2000Params params{.max_bytes = 2000, .lossless = true};
  const Status status = encode(image.view(), {}, params);
  ASSERT_TRUE(status.is(StatusCode::grant_too_small));
  params.max_bytes = static_cast<std::size_t>(status.b);
  ASSERT_TRUE(encode(image.view(), {}, params).ok());
  EXPECT_EQ(product.bytes, params.max_bytes);
  params.max_bytes -= 1;
  EXPECT_TRUE(encode(image.view(), {}, params).is(StatusCode::grant_too_small));
}

TEST_F(Jpeg2000Test, RegionIsBetterThanTheSameBytesWithoutOne) {
  std::vector<std::pair<std::string, Image>> images;
  images.emplace_back("synthetic", detailed_image(512, 384));
  for (const char* strip : {"aerial_caliterra_a", "aerial_coal_oil_point", "strecha_fountain_p11"}) {
    for (const test::StripImage& view : test::read_strip(strip)) {
      images.emplace_back(strip + std::string("/") + view.name, test::read_strip_image(strip, view.name));
      break;
    }
  }
  for (const auto& [name, image] : images) {
    ASSERT_FALSE(image.empty()) << name;
    if (image.width > limits::max_image_side || image.height > limits::max_image_side) continue;
    SCOPED_TRACE(name);
    const Mask mask = disc_mask(image.width, image.height, 0.33);
    Jpeg2000Params params{.max_bytes = bytes_for(0.5, image.view()), .region = RegionCoding::none};
    ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
    const double plain = psnr(image.view(), decode(), mask.view(), true);
    params.region = RegionCoding::shift;
    ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
    const Decoded shifted = decode();
    EXPECT_GE(psnr(image.view(), shifted, mask.view(), true), plain + 3);
    EXPECT_GT(psnr(image.view(), shifted, mask.view(), false), 12) << "the low band shows the rest";
    params.region = RegionCoding::drop_background;
    ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
    EXPECT_GE(psnr(image.view(), decode(), mask.view(), true), plain + 3);
  }
}

TEST_F(Jpeg2000Test, EmptyFullAndSinglePixelMasks) {
  const Image image = textured_image(128, 96);
  for (const RegionCoding coding : {RegionCoding::shift, RegionCoding::drop_background}) {
    for (const int resolutions : {0, 1, 3, 100}) {
      Jpeg2000Params params{
          .max_bytes = file.size(), .region = coding, .region_resolutions = resolutions, .lossless = true};
      const Mask empty = disc_mask(128, 96, 0);
      ASSERT_TRUE(encode(image.view(), empty.view(), params).ok());
      Decoded decoded = decode();
      if (coding == RegionCoding::shift || resolutions == 100) {
        for (std::size_t i = 0; i < image.pixels.size(); ++i) ASSERT_EQ(decoded.pixels[i], image.pixels[i]);
      } else if (resolutions == 0) {
        for (const std::int32_t v : decoded.pixels) ASSERT_EQ(v, 128) << "nothing is region: mid-grey";
      }
      const Mask full = disc_mask(128, 96, 1);
      ASSERT_TRUE(encode(image.view(), full.view(), params).ok());
      EXPECT_EQ(product.shift, 0) << "nothing to tell apart";
      decoded = decode();
      for (std::size_t i = 0; i < image.pixels.size(); ++i) ASSERT_EQ(decoded.pixels[i], image.pixels[i]);
      for (const auto& [px, py] : {std::pair{0, 0}, {127, 95}, {50, 33}}) {
        Mask single = disc_mask(128, 96, 0);
        single.at(px, py) = 1;
        ASSERT_TRUE(encode(image.view(), single.view(), params).ok());
        ASSERT_EQ(decode().at(px, py), image.view().at(px, py));
      }
    }
  }
}

// Five levels have six resolutions: all six are everything, five leave out the finest details.
TEST_F(Jpeg2000Test, CoarsestResolutionsCountAsRegionEverywhere) {
  const Image image = detailed_image(128, 96);
  const Mask empty = disc_mask(128, 96, 0);
  double before = 0;
  for (int resolutions = 0; resolutions <= 6; ++resolutions) {
    Jpeg2000Params params;
    params.max_bytes = file.size();
    params.lossless = true;
    params.region = RegionCoding::drop_background;
    params.region_resolutions = resolutions;
    ASSERT_TRUE(encode(image.view(), empty.view(), params).ok());
    const double quality = psnr(image.view(), decode(), empty.view(), false);
    EXPECT_GT(quality, before + 1) << resolutions;
    EXPECT_EQ(quality > 100, resolutions == 6) << resolutions;
    before = quality;
  }
}

TEST_F(Jpeg2000Test, ScaledCoefficientsThatWouldOverflowAreRefused) {
  Depth depth(64, 64);
  Rng rng(2);
  for (auto& v : depth.pixels) v = static_cast<std::uint16_t>(rng.below(65536));
  const Mask mask = disc_mask(64, 64, 0.3);
  Jpeg2000Params params{.max_bytes = file.size()};
  const Status status = encode(depth, 16, mask.view(), params);
  ASSERT_TRUE(status.is(StatusCode::coefficient_overflow)) << status_name(status.code);
  EXPECT_GT(status.a, 25);
  params.region = RegionCoding::drop_background;
  EXPECT_TRUE(encode(depth, 16, mask.view(), params).ok());
}

// A 12-bit map with a shift stays just below the limit: exact inside and outside.
TEST_F(Jpeg2000Test, ShiftAtTheLimitIsExact) {
  const Depth depth = depth_map(128, 128, 13);
  const Mask mask = disc_mask(128, 128, 0.3);
  Jpeg2000Params params{.max_bytes = file.size(), .lossless = true};
  ASSERT_TRUE(encode(depth, 13, mask.view(), params).ok());
  EXPECT_GT(product.shift, 0);
  const Decoded decoded = decode();
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) ASSERT_EQ(decoded.pixels[i], depth.pixels[i]);
}

TEST_F(Jpeg2000Test, LayersCutToCompleteFilesOfTheAnnouncedSize) {
  const Image image = textured_image(320, 240);
  const Mask mask = disc_mask(320, 240, 0.33);
  metadata.assign(77, 'k');
  for (const RegionCoding coding : {RegionCoding::shift, RegionCoding::drop_background}) {
    Jpeg2000Params params{.max_bytes = 20000, .region = coding, .layers = 5};
    ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
    ASSERT_EQ(product.layers, 5);
    EXPECT_EQ(product.layer_bytes[4], product.bytes);
    double before = 0;
    for (int layers = 1; layers <= 5; ++layers) {
      std::vector<std::uint8_t> copy(bytes().begin(), bytes().end());
      std::size_t size = 0;
      ASSERT_TRUE(truncate_to_layers(copy, layers, size).ok());
      EXPECT_EQ(size, product.layer_bytes[static_cast<std::size_t>(layers - 1)]);
      copy.resize(size);
      Jpeg2000Info info;
      ASSERT_TRUE(read_jpeg2000_header(copy, info).ok());
      EXPECT_EQ(info.layers, layers);
      EXPECT_EQ(info.metadata.size(), metadata.size());
      const double quality = psnr(image.view(), decode(copy), mask.view(), true);
      EXPECT_GT(quality, before + 0.5) << "layer " << layers;
      before = quality;
      // Cutting what is cut already gives the same bytes as cutting once.
      std::vector<std::uint8_t> again(bytes().begin(), bytes().end());
      std::size_t first_size = 0;
      ASSERT_TRUE(truncate_to_layers(again, 5, first_size).ok());
      ASSERT_TRUE(truncate_to_layers(std::span(again).first(first_size), layers, size).ok());
      again.resize(size);
      EXPECT_EQ(again, copy);
    }
    std::vector<std::uint8_t> copy(bytes().begin(), bytes().end());
    std::size_t size = 0;
    EXPECT_TRUE(truncate_to_layers(copy, 0, size).is(StatusCode::invalid_argument));
    EXPECT_TRUE(truncate_to_layers(copy, 6, size).is(StatusCode::invalid_argument));
  }
}

// The search for a layer's passes must not end before it has found them. It begins at the steepest slope, and the
// passes of a depth map with all its bits are many powers of ten less steep.
TEST_F(Jpeg2000Test, LayersFillTheBytesThatTheyMayHave) {
  Depth depth = depth_map(640, 480, 13);
  Rng rng(11);
  for (auto& sample : depth.pixels) sample = static_cast<std::uint16_t>(sample / 2 + 1000 + rng.below(16));
  const Mask mask = disc_mask(640, 480, 0.33);
  Jpeg2000Params params;
  params.max_bytes = 60000;
  params.layers = 4;
  params.layer_ratio = 0.7;
  params.region = RegionCoding::drop_background;
  params.region_resolutions = 0;
  ASSERT_TRUE(encode(depth, 13, mask.view(), params).ok());
  ASSERT_EQ(product.layers, 4);
  double expected = 60000;
  for (std::size_t layer = 4; layer-- > 0; expected *= 0.7) {
    EXPECT_NEAR(static_cast<double>(product.layer_bytes[layer]) / expected, 1, 0.02) << layer;
  }
}

// Our transform is the library's: the image goes through either to the same file.
TEST_F(Jpeg2000Test, WhereTheLibraryTransformsTheFileIsThatWithoutARegion) {
  const Depth depth = depth_map(211, 157, 13);
  const Mask mask = disc_mask(211, 157, 0.2);
  for (const std::size_t ceiling : {std::size_t{2500}, std::size_t{9000}, file.size()}) {
    for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift, RegionCoding::drop_background}) {
      for (const bool lossless : {false, true}) {
        Jpeg2000Params params;
        params.max_bytes = ceiling;
        params.layers = 4;
        params.lossless = lossless && ceiling == file.size();
        params.region = coding;
        params.library_transform = true;
        ASSERT_TRUE(encode(depth, 13, mask.view(), params).ok());
        EXPECT_EQ(product.shift, 0);
        EXPECT_LE(product.bytes, ceiling);
        const std::vector<std::uint8_t> with_library(bytes().begin(), bytes().end());
        if (ceiling == file.size() && (params.lossless || coding != RegionCoding::shift)) {
          const Decoded decoded = decode();
          for (std::size_t i = 0; i < depth.pixels.size(); ++i) ASSERT_EQ(decoded.pixels[i], depth.pixels[i]);
        }
        params.library_transform = false;
        ASSERT_TRUE(encode(depth, 13, {}, params).ok());
        EXPECT_EQ(with_library, std::vector<std::uint8_t>(bytes().begin(), bytes().end()));
      }
    }
  }
}

TEST_F(Jpeg2000Test, SameInputSameBytes) {
  const Image image = textured_image(200, 150);
  const Mask mask = disc_mask(200, 150, 0.4);
  Jpeg2000Params params{.max_bytes = 5000, .layers = 3};
  ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
  const std::vector<std::uint8_t> first(bytes().begin(), bytes().end());
  const Depth depth = depth_map(300, 100, 12);
  ASSERT_TRUE(encode(depth, 12, {}, params).ok());
  ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
  EXPECT_EQ(first, std::vector<std::uint8_t>(bytes().begin(), bytes().end()));
}

TEST_F(Jpeg2000Test, MetadataTravelsUnchanged) {
  const Image image = textured_image(64, 64);
  Jpeg2000Params params{.max_bytes = file.size()};
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{4096}}) {
    metadata.resize(size);
    for (std::size_t i = 0; i < size; ++i) metadata[i] = static_cast<std::uint8_t>(i * 7);
    ASSERT_TRUE(encode(image.view(), {}, params).ok());
    Jpeg2000Info info;
    ASSERT_TRUE(read_jpeg2000_header(bytes(), info).ok());
    EXPECT_EQ(std::vector<std::uint8_t>(info.metadata.begin(), info.metadata.end()), metadata);
    EXPECT_EQ(info.bits, 8);
    EXPECT_FALSE(info.is_signed);
  }
  metadata.resize(limits::max_metadata_bytes + 1);
  EXPECT_TRUE(encode(image.view(), {}, params).is(StatusCode::capacity_exceeded));
}

TEST_F(Jpeg2000Test, BadArgumentsAreNamed) {
  const Image image = textured_image(64, 64);
  const Mask other = disc_mask(64, 63, 0.5);
  Jpeg2000Params params{.max_bytes = file.size()};
  EXPECT_TRUE(encode(image.view(), other.view(), params).is(StatusCode::invalid_argument));
  EXPECT_TRUE(encode(GrayView(), {}, params).is(StatusCode::invalid_argument));
  const GrayView huge(image.pixels.data(), 100000, 100000);
  EXPECT_TRUE(encode(huge, {}, params).is(StatusCode::image_too_large));
  params.layers = 9;
  EXPECT_TRUE(encode(image.view(), {}, params).is(StatusCode::invalid_argument));
  Depth depth(16, 16);
  depth.pixels[100] = 256;
  EXPECT_TRUE(encode(depth, 8, {}, Jpeg2000Params{.max_bytes = 9999}).is(StatusCode::invalid_argument));
  EXPECT_TRUE(encode(depth, 17, {}, Jpeg2000Params{.max_bytes = 9999}).is(StatusCode::invalid_argument));
}

// ---- another program's view ----

TEST_F(Jpeg2000Test, OpjDecompressAgreesOnEveryProduct) {
  if (std::system("command -v opj_decompress > /dev/null 2>&1") != 0) GTEST_SKIP() << "opj_decompress is not installed";
  const std::string stem = ::testing::TempDir() + "ilp_product_" + std::to_string(getpid());
  const auto check = [&](int bits) {
    std::ofstream(stem + ".jp2", std::ios::binary)
        .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(product.bytes));
    const std::string command = "opj_decompress -i " + stem + ".jp2 -o " + stem + ".pgm > " + stem + ".log 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    const Pgm pgm = read_pgm(stem + ".pgm");
    EXPECT_EQ(pgm.maximum, (1 << bits) - 1);
    EXPECT_EQ(pgm.samples.pixels, decode().pixels);
  };
  const Image image = textured_image(241, 160);
  const Mask mask = disc_mask(241, 160, 0.3);
  metadata.assign(50, 'x');
  for (const RegionCoding coding : {RegionCoding::none, RegionCoding::shift, RegionCoding::drop_background}) {
    for (const int layers : {1, 4}) {
      for (const bool lossless : {false, true}) {
        Jpeg2000Params params{
            .max_bytes = lossless ? file.size() : 4000, .region = coding, .layers = layers, .lossless = lossless};
        ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
        check(8);
        std::size_t size = 0;
        ASSERT_TRUE(truncate_to_layers(std::span(file).first(product.bytes), 1, size).ok());
        product.bytes = size;
        check(8);
        const Depth depth = depth_map(130, 97, 13);
        const Mask depth_mask = disc_mask(130, 97, 0.3);
        ASSERT_TRUE(encode(depth, 13, depth_mask.view(), params).ok());
        check(13);
      }
    }
  }
  for (const char* suffix : {".jp2", ".pgm", ".log"}) std::remove((stem + suffix).c_str());
}

// ---- other people's streams ----

std::vector<std::uint8_t> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// Header "PG ML [+-] [ ]depth width height", then samples, big-endian.
Decoded read_pgx(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string magic;
  std::string order;
  in >> magic >> order;
  char sign = '+';
  if ((in >> std::ws).peek() == '+' || in.peek() == '-') in >> sign;
  int depth = 0;
  int width = 0;
  int height = 0;
  in >> depth >> width >> height;
  in.get();
  Decoded samples(width, height);
  for (auto& v : samples.pixels) {
    v = in.get();
    if (depth > 8) v = v * 256 + in.get();
    if (sign == '-' && depth <= 8 && v > 127) v -= 256;
  }
  return samples;
}

TEST(Jpeg2000Conformance, SingleComponentStreamsDecodeExactly) {
  const std::string folder = std::string(test::data_root) + "jpeg2000_conformance/";
  if (read_file(folder + "p0_03.j2k").empty()) GTEST_SKIP() << "no conformance streams in " << folder;
  for (const char* name : {"p0_01", "p0_03", "p0_09", "p0_11", "p1_01"}) {
    SCOPED_TRACE(name);
    const auto stream = read_file(folder + name + ".j2k");
    const Decoded truth = read_pgx(folder + "c1" + name + "_0.pgx");
    Jpeg2000Info info;
    ASSERT_TRUE(read_jpeg2000_header(stream, info).ok());
    EXPECT_EQ(info.width, truth.width);
    EXPECT_EQ(info.height, truth.height);
    Decoded samples(info.width, info.height);
    ASSERT_TRUE(decode_jpeg2000(stream, false, {samples.pixels.data(), info.width, info.height}).ok());
    EXPECT_EQ(samples.pixels, truth.pixels);
  }
  for (const char* name : {"p0_13", "p0_14", "p1_06"}) {
    const auto stream = read_file(folder + name + ".j2k");
    Jpeg2000Info info;
    EXPECT_TRUE(read_jpeg2000_header(stream, info).is(StatusCode::unsupported_format)) << name;
  }
}

TEST_F(Jpeg2000Test, TruncatedFilesDecodeInPartOnlyWhenAllowed) {
  const Image image = textured_image(160, 120);
  Jpeg2000Params params{.max_bytes = 8000};
  ASSERT_TRUE(encode(image.view(), {}, params).ok());
  const Mask all = disc_mask(160, 120, 1);
  for (const std::size_t size : {product.bytes - 2, product.bytes / 2}) {
    Decoded samples(160, 120);
    const auto part = bytes().first(size);
    EXPECT_FALSE(decode_jpeg2000(part, false, {samples.pixels.data(), 160, 120}).ok() && size < product.bytes - 2);
    ASSERT_TRUE(decode_jpeg2000(part, true, {samples.pixels.data(), 160, 120}).ok());
    EXPECT_GT(psnr(image.view(), samples, all.view(), true), 20);
  }
}

TEST_F(Jpeg2000Test, HostileInputIsAStatus) {
  const Image image = textured_image(60, 40);
  Jpeg2000Params params{.max_bytes = file.size(), .layers = 3};
  metadata.assign(20, 'z');
  const Mask mask = disc_mask(60, 40, 0.3);
  ASSERT_TRUE(encode(image.view(), mask.view(), params).ok());
  const std::vector<std::uint8_t> good(bytes().begin(), bytes().end());
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 40) {
    const std::span<const std::uint8_t> part = std::span(good).first(size);
    Decoded samples(60, 40);
    static_cast<void>(decode_jpeg2000(part, true, {samples.pixels.data(), 60, 40}));
    std::vector<std::uint8_t> copy(part.begin(), part.end());
    std::size_t cut = 0;
    static_cast<void>(truncate_to_layers(copy, 1, cut));
    EXPECT_LE(cut, size);
  }
  Rng rng(9);
  int refused = 0;
  for (int trial = 0; trial < 600; ++trial) {
    std::vector<std::uint8_t> bad = good;
    const std::uint32_t damages = 1 + rng.below(4);
    // Most damage to the boxes and headers, where it can do most.
    for (std::uint32_t i = 0; i < damages; ++i) {
      const std::uint32_t reach = rng.below(3) == 0 ? static_cast<std::uint32_t>(bad.size()) : 300;
      bad[rng.below(reach)] = static_cast<std::uint8_t>(rng.next());
    }
    std::size_t cut = 0;
    std::vector<std::uint8_t> copy = bad;
    if (truncate_to_layers(copy, 2, cut).ok()) {
      EXPECT_LE(cut, bad.size());
    }
    Jpeg2000Info info;
    if (!read_jpeg2000_header(bad, info).ok() || static_cast<std::int64_t>(info.width) * info.height > 1 << 20) {
      ++refused;
      continue;
    }
    Decoded samples(info.width, info.height);
    if (!decode_jpeg2000(bad, trial % 2 == 0, {samples.pixels.data(), info.width, info.height}).ok()) ++refused;
  }
  EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace ilp
