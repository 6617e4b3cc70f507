// Masks survive their bytes exactly; bytes that no encoder wrote are refused and never write outside.
#include <gtest/gtest.h>

#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/terrain/bit_coder.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"

namespace ilp {
namespace {

struct Mask {
  std::int32_t width, height;
  std::vector<std::uint8_t> pixels;
  Mask(std::int32_t w, std::int32_t h) : width(w), height(h), pixels(static_cast<std::size_t>(w * h)) {}
  [[nodiscard]] ImageView<std::uint8_t> view() { return {pixels.data(), width, height}; }
};

std::vector<std::uint8_t> encode(Mask& mask) {
  std::vector<std::uint8_t> bytes(max_mask_bytes(mask.pixels.size()));
  std::size_t size = 0;
  EXPECT_TRUE(encode_mask(mask.view(), bytes.data(), bytes.size(), size).ok());
  bytes.resize(size);
  return bytes;
}

void expect_round_trip(Mask mask) {
  const std::vector<std::uint8_t> bytes = encode(mask);
  Mask back(mask.width, mask.height);
  ASSERT_TRUE(decode_mask(bytes.data(), bytes.size(), back.view()).ok());
  EXPECT_EQ(mask.pixels, back.pixels);
}

TEST(MaskCoding, AnyMaskComesBack) {
  Rng rng(4);
  for (const std::uint32_t density : {0U, 1U, 3U, 50U, 97U, 100U}) {
    for (const auto& [w, h] : {std::pair{64, 64}, std::pair{1, 1}, std::pair{7, 3}, std::pair{333, 211}}) {
      Mask mask(w, h);
      for (auto& p : mask.pixels) p = rng.below(100) < density ? 255 : 0;
      expect_round_trip(mask);
    }
  }
}

TEST(MaskCoding, RegionsOfAFlightTakeFewBytesAndNoiseAtMostOneBitAPixel) {
  Mask strip(640, 480);
  for (std::int32_t y = 0; y < 480; ++y) {
    for (std::int32_t x = 500 + y / 10; x < 640; ++x) strip.view().at(x, y) = 255;
  }
  EXPECT_LT(encode(strip).size(), 160U);
  Mask noise(640, 480);
  Rng rng(1);
  for (auto& p : noise.pixels) p = rng.below(2) != 0 ? 255 : 0;
  EXPECT_EQ(encode(noise).size(), 1 + 640U * 480 / 8);
}

// Whoever cuts or lengthens the coded form is found out; a changed byte may only give another mask.
TEST(MaskCoding, ContextsEndWhereTheEncoderEnded) {
  Mask disc(120, 90);
  for (std::int32_t y = 0; y < 90; ++y) {
    for (std::int32_t x = 0; x < 120; ++x) disc.view().at(x, y) = (x - 50) * (x - 50) + (y - 40) * (y - 40) < 900;
  }
  std::vector<std::uint8_t> bytes = encode(disc);
  ASSERT_EQ(bytes[0], 2);
  Mask back(120, 90);
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    EXPECT_FALSE(decode_mask(bytes.data(), size, back.view()).ok()) << size;
  }
  bytes.push_back(0);
  EXPECT_EQ(decode_mask(bytes.data(), bytes.size(), back.view()).code, StatusCode::parse_error);
}

TEST(MaskCoding, ARaggedMaskTakesLessThanItsRuns) {
  Mask ragged(640, 480);
  Rng rng(6);
  std::int32_t edge = 400;
  std::size_t runs = 1;
  for (std::int32_t y = 0; y < 480; ++y) {
    edge += static_cast<std::int32_t>(rng.below(3)) - 1;
    for (std::int32_t x = edge; x < 640; ++x) ragged.view().at(x, y) = 255;
    runs += 4;
  }
  EXPECT_LT(encode(ragged).size(), runs / 5);
  expect_round_trip(ragged);
}

TEST(MaskCoding, TooSmallABufferIsRefused) {
  Mask mask(100, 100);
  std::uint8_t byte = 0;
  std::size_t size = 0;
  EXPECT_EQ(encode_mask(mask.view(), &byte, 1, size).code, StatusCode::capacity_exceeded);
}

TEST(MaskCoding, DamagedBytesAreRefused) {
  const auto decode = [](std::vector<std::uint8_t> bytes) {
    Mask mask(10, 10);
    return decode_mask(bytes.data(), bytes.size(), mask.view()).code;
  };
  EXPECT_EQ(decode({}), StatusCode::truncated);
  EXPECT_EQ(decode({3, 0}), StatusCode::parse_error);
  EXPECT_EQ(decode({2, 0}), StatusCode::truncated);
  EXPECT_EQ(decode({1}), StatusCode::truncated);
  EXPECT_EQ(decode({1, 100}), StatusCode::ok);
  EXPECT_EQ(decode({1, 101}), StatusCode::parse_error);
  EXPECT_EQ(decode({1, 50}), StatusCode::truncated);
  EXPECT_EQ(decode({1, 50, 0, 50}), StatusCode::parse_error);
  EXPECT_EQ(decode({1, 50, 50, 1}), StatusCode::parse_error);
  EXPECT_EQ(decode({1, 0x80}), StatusCode::truncated);
  EXPECT_EQ(decode({1, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01}), StatusCode::parse_error);
  EXPECT_EQ(decode({1, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F}), StatusCode::parse_error);
  EXPECT_EQ(decode(std::vector<std::uint8_t>(13, 0)), StatusCode::truncated);
  EXPECT_EQ(decode(std::vector<std::uint8_t>(14, 0)), StatusCode::ok);
  EXPECT_EQ(decode(std::vector<std::uint8_t>(15, 0)), StatusCode::parse_error);
  std::vector<std::uint8_t> padding(14, 0);
  padding[13] = 0x10;
  EXPECT_EQ(decode(padding), StatusCode::parse_error);
}

TEST(MaskCoding, RandomBytesNeverWriteOutside) {
  Rng rng(8);
  for (int trial = 0; trial < 20000; ++trial) {
    std::vector<std::uint8_t> bytes(rng.below(40));
    for (auto& b : bytes) b = static_cast<std::uint8_t>(rng.below(256));
    if (!bytes.empty()) bytes[0] = static_cast<std::uint8_t>(rng.below(4));
    std::vector<std::uint8_t> guarded(16 + 17 * 9 + 16, 0x5A);
    (void)decode_mask(bytes.data(), bytes.size(), ImageView<std::uint8_t>(guarded.data() + 16, 17, 9));
    for (std::size_t i = 0; i < 16; ++i) {
      ASSERT_EQ(guarded[i], 0x5A);
      ASSERT_EQ(guarded[guarded.size() - 1 - i], 0x5A);
    }
  }
}

struct RunOfBits {
  std::uint32_t context, bit;
  std::size_t count;
};

// Runs of up to 200 000 bits: several renewals of the range, and all sizes that it has meanwhile.
std::vector<RunOfBits> runs_of_bits() {
  std::vector<RunOfBits> runs;
  Rng rng(5, 7);
  for (int i = 0; i < 400; ++i) {
    const auto context = static_cast<std::uint32_t>(rng.below(3)), bit = static_cast<std::uint32_t>(rng.below(2));
    runs.push_back({context, bit, 1 + rng.below(i % 40 == 0 ? 200000 : 3000)});
    // Only long runs of one bit settle a context, and only one other bit unsettles it.
    if (i % 3 == 0) runs.push_back({context, bit, 4000});
  }
  return runs;
}

TEST(MaskCoding, ARunIsCodedAsItsSingleBits) {
  const std::vector<RunOfBits> runs = runs_of_bits();
  std::vector<std::uint8_t> single(1U << 20U), together(single.size());
  BitEncoder<3> by_bits(single.data(), single.size()), by_runs(together.data(), together.size());
  for (const RunOfBits& run : runs) {
    for (std::size_t k = 0; k < run.count; ++k) by_bits.encode(run.context, run.bit);
    by_runs.encode_run(run.context, run.bit, run.count);
  }
  const std::size_t bytes = by_bits.finish();
  ASSERT_EQ(by_runs.finish(), bytes);
  ASSERT_EQ(single, together);

  BitDecoder<3> bits(single.data(), bytes), in_runs(single.data(), bytes);
  for (const RunOfBits& run : runs) {
    for (std::size_t k = 0; k < run.count; ++k) ASSERT_EQ(bits.decode(run.context), run.bit);
    ASSERT_EQ(in_runs.decode_run(run.context, run.bit, run.count), run.count);
  }
  EXPECT_EQ(in_runs.used(), bits.used());
}

TEST(MaskCoding, ARunEndsAtTheOtherBit) {
  std::vector<std::uint8_t> bytes(1U << 16U);
  for (const std::uint32_t usual : {0U, 1U}) {
    BitEncoder<1> coder(bytes.data(), bytes.size());
    Rng rng(6, usual);
    std::vector<std::size_t> lengths;
    for (int i = 0; i < 60; ++i) lengths.push_back(rng.below(i % 2 == 0 ? 20000 : 3000));
    for (const std::size_t length : lengths) {
      for (std::size_t k = 0; k < length; ++k) coder.encode(0, usual);
      coder.encode(0, usual ^ 1U);
    }
    const std::size_t size = coder.finish();
    BitDecoder<1> decoder(bytes.data(), size);
    for (const std::size_t length : lengths) ASSERT_EQ(decoder.decode_run(0, usual, 100000), length);
  }
}

}  // namespace
}  // namespace ilp
