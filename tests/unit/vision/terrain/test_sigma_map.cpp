// Errors by block, as the ground reads them.
#include <gtest/gtest.h>

#include <vector>

#include "fsw/vision/terrain/sigma_map.hpp"

namespace ilp {
namespace {

struct Codes {
  std::int32_t width, height;
  std::vector<std::uint8_t> code, mask;
  Codes(std::int32_t w, std::int32_t h, std::uint8_t value)
      : width(w), height(h), code(static_cast<std::size_t>(w * h), value), mask(code.size(), 255) {}
  std::string encode() {
    std::vector<char> out(max_sigma_map_bytes);
    std::size_t size = 0;
    EXPECT_TRUE(encode_sigma_map({code.data(), width, height}, {mask.data(), width, height}, out, size).ok());
    return {out.data(), size};
  }
};

TEST(SigmaMap, EveryCodeComesBackWithinNinePercentAndNeverSmaller) {
  for (int code = 1; code <= sigma_code_largest; ++code) {
    const std::string map = Codes(32, 32, static_cast<std::uint8_t>(code)).encode();
    ASSERT_EQ(map.size(), 1U);
    EXPECT_EQ(Codes(32, 32, static_cast<std::uint8_t>(code | sigma_code_supported)).encode(), map);
    const double back = sigma_of_character(map[0]);
    EXPECT_GE(back, code - 1e-9);
    EXPECT_LE(back, 1.0906 * code);
    EXPECT_GE(map[0], '!');
    EXPECT_LE(map[0], '~');
  }
}

TEST(SigmaMap, CodesAreRoundedUpAndSayWhatIsSupported) {
  // Two rows of 66 pixels, so that the last two of each are in a word of their own.
  constexpr std::int32_t width = 66;
  std::vector<float> sigma(2 * width);
  std::vector<std::uint8_t> expected(sigma.size()), codes(sigma.size());
  std::vector<std::uint64_t> supported(4);
  const auto put = [&](std::size_t x, std::size_t y, float error, bool is_supported, int code) {
    sigma[y * width + x] = error;
    if (is_supported) supported[2 * y + x / 64] |= std::uint64_t{1} << (x % 64);
    expected[y * width + x] = static_cast<std::uint8_t>(code);
  };
  put(1, 0, 0.1F, false, 7);
  put(2, 0, 0.1F, true, 128 + 7);
  put(3, 0, 100, false, 127);
  put(63, 0, 100, true, 128 + 127);
  put(64, 0, 1.0F / 64, false, 1);
  put(65, 0, 1.0F / 64, true, 128 + 1);
  put(0, 1, 1.0F / 64, true, 128 + 1);
  put(65, 1, 0, true, 0);
  EXPECT_EQ(code_sigma({{}, {sigma.data(), width, 2}, {supported.data(), 2, 2}}, 1, codes.data()), 4U);
  EXPECT_EQ(codes, expected);
}

TEST(SigmaMap, ABlockSaysTheMedianOfWhatTheMaskClaims) {
  Codes codes(70, 40, 64);
  for (std::int32_t y = 0; y < 40; ++y) {
    for (std::int32_t x = 0; x < 70; ++x) {
      const auto i = static_cast<std::size_t>(y * 70 + x);
      if (x >= 32 && x < 64) codes.mask[i] = 0;
      if (x < 32 && y < 32 && x % 4 == 0) codes.code[i] = 0;    // no depth: does not count
      if (x < 32 && y < 32 && x % 4 == 1) codes.code[i] = 127;  // a third of the rest
      if (x >= 64) codes.code[i] = 16;
    }
  }
  const std::string map = codes.encode();
  ASSERT_EQ(map.size(), 6U);
  EXPECT_DOUBLE_EQ(sigma_of_character(map[0]), 64);
  EXPECT_EQ(map[1], sigma_map_none);
  EXPECT_DOUBLE_EQ(sigma_of_character(map[2]), 16);
  EXPECT_DOUBLE_EQ(sigma_of_character(map[3]), 64);
}

TEST(SigmaMap, WhatDoesNotFitIsRefusedAndStrangeCharactersSayNothing) {
  Codes codes(64, 64, 10);
  std::vector<char> out(3);
  std::size_t size = 0;
  EXPECT_EQ(encode_sigma_map({codes.code.data(), 64, 64}, {codes.mask.data(), 64, 64}, out, size).code,
            StatusCode::capacity_exceeded);
  EXPECT_EQ(encode_sigma_map({codes.code.data(), 64, 64}, {codes.mask.data(), 64, 32}, out, size).code,
            StatusCode::invalid_argument);
  EXPECT_EQ(sigma_of_character('!'), 0);
  EXPECT_EQ(sigma_of_character('~'), 0);
  EXPECT_EQ(sigma_of_character(' '), 0);
  EXPECT_EQ(sigma_of_character('\xff'), 0);
}

}  // namespace
}  // namespace ilp
