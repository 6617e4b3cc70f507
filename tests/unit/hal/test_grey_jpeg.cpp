// Luma of JPEG pictures, valid and hostile.
#include "hal/camera/jpeg/grey_jpeg.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "hal/camera/camera.hpp"
#include "tests/support/jpeg_file.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

using test::jpeg_file;
using test::JpegKind;
using Bytes = std::vector<std::uint8_t>;

constexpr std::int32_t width = 83, height = 70;  // no multiples of a block

std::uint8_t hills(std::int32_t x, std::int32_t y) {
  return static_cast<std::uint8_t>(std::lround(128 + 100 * std::sin(0.11 * x) * std::cos(0.09 * y)));
}

/// Every block of 8 x 8 pixels has a grey value of its own.
std::uint8_t tiles(std::int32_t x, std::int32_t y) {
  return static_cast<std::uint8_t>(x / 8 * 37 + y / 8 * 91 + 5);
}

class GreyJpeg : public testing::Test {
 protected:
  [[nodiscard]] Status decode(std::span<const std::uint8_t> file, std::int32_t w = width, std::int32_t h = height) {
    Reduction reduction;
    ILP_TRY(find_reduction(w, h, reduction));
    ILP_TRY(image->resize(reduction.width, reduction.height));
    reducer->begin(reduction, image->view());
    return decode_grey_jpeg(file, w, h, row, *reducer);
  }
  [[nodiscard]] int worst_difference(const test::Luma& truth) const {
    int worst = 0;
    for (std::int32_t y = 0; y < image->height(); ++y) {
      for (std::int32_t x = 0; x < image->width(); ++x) {
        worst = std::max(worst, std::abs(image->view().at(x, y) - truth(x, y)));
      }
    }
    return worst;
  }

  std::unique_ptr<FrameImage> image = std::make_unique<FrameImage>();
  std::unique_ptr<RowReducer> reducer = std::make_unique<RowReducer>();
  Bytes row = Bytes(static_cast<std::size_t>(limits::max_sensor_side));
};

std::vector<JpegKind> understood() {
  return {{.colour = false},
          {.horizontal = 1, .vertical = 1},
          {.horizontal = 2, .vertical = 1},
          {.horizontal = 2, .vertical = 2},
          {.horizontal = 4, .vertical = 1},
          {.horizontal = 2, .vertical = 1, .restart_rows = 1},
          {.horizontal = 2, .vertical = 1, .standard_tables_left_out = true},
          {.colour = false, .standard_tables_left_out = true}};
}

// A uniform block has one coefficient, which is exact in integers at quality 100.
TEST_F(GreyJpeg, UniformBlocksAreExact) {
  for (const JpegKind& kind : understood()) {
    ASSERT_OK(decode(jpeg_file(width, height, tiles, kind)));
    // Blocks at the border are not uniform where the picture ends within them: the encoder repeats its last pixels.
    EXPECT_EQ(worst_difference(tiles), 0) << kind.horizontal << kind.vertical << kind.colour << kind.restart_rows;
  }
}

// Each of 64 coefficients is rounded by at most a half: the mean error is some tenths.
TEST_F(GreyJpeg, APictureAtFullQualityDiffersByRoundingOnly) {
  for (const JpegKind& kind : understood()) {
    ASSERT_OK(decode(jpeg_file(width, height, hills, kind)));
    EXPECT_LE(worst_difference(hills), 2) << kind.horizontal << kind.vertical;
  }
}

TEST_F(GreyJpeg, ALargePictureIsReducedRowByRow) {
  const std::int32_t large = limits::max_image_width * 2;
  Reduction reduction;
  ASSERT_OK(find_reduction(large, 100, reduction));
  ASSERT_EQ(reduction.factor, 2);
  const auto stripes = [](std::int32_t x, std::int32_t) { return static_cast<std::uint8_t>(x / 8 % 2 * 90 + 60); };
  ASSERT_OK(decode(jpeg_file(large, 100, stripes), large, 100));
  EXPECT_EQ(worst_difference([&](std::int32_t x, std::int32_t y) { return stripes(2 * x, y); }), 0);
}

TEST_F(GreyJpeg, KindsThatNeedAWholePictureInMemoryAreRefused) {
  EXPECT_STATUS(decode(jpeg_file(width, height, hills, {.progressive = true})), unsupported_format);
  EXPECT_STATUS(decode(jpeg_file(width, height, hills, {.one_scan_per_component = true})), unsupported_format);
  EXPECT_STATUS(decode(jpeg_file(width, height, hills, {.arithmetic = true})), unsupported_format);
}

TEST_F(GreyJpeg, AnotherSizeIsRefusedWithIt) {
  const Bytes file = jpeg_file(width, height, hills);
  const Status status = decode(file, width, height + 1);
  EXPECT_STATUS(status, image_size_changed);
  EXPECT_EQ(status.a, width);
  EXPECT_EQ(status.b, height);
  EXPECT_FALSE(decode(file, 0, height).ok());
  EXPECT_FALSE(decode_grey_jpeg(file, width, height, std::span(row).first(10), *reducer).ok());
}

TEST_F(GreyJpeg, PaddingBehindTheFileIsLeftAlone) {
  Bytes file = jpeg_file(width, height, tiles);
  file.resize(file.size() + 5000);
  ASSERT_OK(decode(file));
  EXPECT_EQ(worst_difference(tiles), 0);
}

TEST_F(GreyJpeg, EveryTruncationIsRefused) {
  for (const JpegKind& kind : {JpegKind{.quality = 30}, JpegKind{.quality = 30, .colour = false, .restart_rows = 1}}) {
    const Bytes file = jpeg_file(width, height, hills, kind);
    // Without the mark of the end, all rows may be there.
    for (std::size_t size = 0; size + 3 < file.size(); ++size) {
      ASSERT_FALSE(decode(std::span(file).first(size)).ok()) << size << " of " << file.size();
    }
    ASSERT_OK(decode(file)) << "the next one is not impaired";
  }
}

// A flipped bit is refused or leaves a picture that may differ: JPEG has no checksum. What must not happen is seen by
// the sanitizers, and by the picture after it.
TEST_F(GreyJpeg, FlippedBitsAreRefusedOrDecoded) {
  const Bytes file = jpeg_file(64, 64, hills, {.quality = 20, .horizontal = 2, .vertical = 1});
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    Bytes damaged = file;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    if (!decode(damaged, 64, 64).ok()) ++refused;
  }
  EXPECT_GT(refused, file.size()) << "an eighth";
  EXPECT_LT(refused, 8 * file.size());
  ASSERT_OK(decode(jpeg_file(width, height, tiles)));
  EXPECT_EQ(worst_difference(tiles), 0);
}

TEST_F(GreyJpeg, NoiseIsRefused) {
  std::mt19937 random(2);
  const Bytes file = jpeg_file(64, 64, hills);
  for (int i = 0; i < 2000; ++i) {
    Bytes noise(random() % 400);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    if (i % 2 == 0 && noise.size() >= 2) {
      noise[0] = 0xFF;
      noise[1] = 0xD8;
    }
    ASSERT_FALSE(decode(noise, 64, 64).ok());
    // Behind a valid beginning.
    Bytes half(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() / 2));
    half.insert(half.end(), noise.begin(), noise.end());
    ASSERT_FALSE(decode(half, 64, 64).ok());
  }
}

}  // namespace
}  // namespace ilp
