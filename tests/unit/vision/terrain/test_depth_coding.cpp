// Quantised inverse depth: the error bound holds at every pixel, the codes fit, foreign codes are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 90;
constexpr std::int32_t height = 70;
constexpr std::size_t pixels = width * height;
constexpr double focal_px = 600;
constexpr double baseline = 18;

struct Map {
  std::vector<float> inverse_depth = std::vector<float>(pixels, 0);
  std::vector<float> sigma = std::vector<float>(pixels, 0);
  std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(pixels, 255);
  std::vector<std::uint16_t> codes = std::vector<std::uint16_t>(pixels, 77);

  [[nodiscard]] ImageView<const float> rho() const { return {inverse_depth.data(), width, height}; }
  [[nodiscard]] ImageView<const float> error() const { return {sigma.data(), width, height}; }
  [[nodiscard]] MaskView inside() const { return {mask.data(), width, height}; }
  [[nodiscard]] ImageView<std::uint16_t> out() { return {codes.data(), width, height}; }
};

/// Depths between the two, a third of the pixels invalid, a fifth outside the mask.
Map random_map(double nearest, double farthest) {
  Map m;
  Rng rng(9);
  for (std::size_t i = 0; i < pixels; ++i) {
    m.inverse_depth[i] = static_cast<float>(1 / (nearest + (farthest - nearest) * rng.uniform()));
    m.sigma[i] = rng.below(3) == 0 ? 0.0F : 1e-4F;
    m.mask[i] = rng.below(5) == 0 ? 0 : 255;
  }
  return m;
}

class DepthCodingOver : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(DepthCodingOver, EveryPixelComesBackWithinHalfAStep) {
  Map m = random_map(GetParam().first, GetParam().second);
  DepthCoding coding;
  ASSERT_TRUE(choose_depth_coding(m.rho(), m.error(), m.inside(), focal_px, baseline, 16, coding).ok());
  ASSERT_TRUE(encode_depth(m.rho(), m.error(), m.inside(), coding, m.out()).ok());
  std::vector<float> back(pixels, -1);
  ASSERT_TRUE(decode_depth(m.out(), coding, {back.data(), width, height}).ok());
  for (std::size_t i = 0; i < pixels; ++i) {
    const bool present = m.sigma[i] > 0 && m.mask[i] != 0;
    ASSERT_EQ(m.codes[i] != 0, present);
    ASSERT_LT(m.codes[i], 1 << 13);
    if (!present) {
      ASSERT_EQ(back[i], 0);
      continue;
    }
    const double error = std::fabs(static_cast<double>(back[i]) - static_cast<double>(m.inverse_depth[i]));
    // Half a step, and the rounding of the result to single precision.
    ASSERT_LE(error, 0.5 * coding.step * (1 + 1e-9) + 6e-8 * static_cast<double>(m.inverse_depth[i]));
  }
}

INSTANTIATE_TEST_SUITE_P(Ranges, DepthCodingOver,
                         ::testing::Values(std::pair{80.0, 120.0}, std::pair{99.99, 100.01}, std::pair{5.0, 3000.0},
                                           std::pair{0.1, 1e6}, std::pair{100.0, 100.0}));

TEST(DepthCoding, StepIsASixteenthOfAPixelWhereTheRangeAllows) {
  const Map m = random_map(80, 120);
  DepthCoding coding;
  ASSERT_TRUE(choose_depth_coding(m.rho(), m.error(), m.inside(), focal_px, baseline, 16, coding).ok());
  EXPECT_DOUBLE_EQ(coding.step, 1 / (16 * focal_px * baseline));
}

TEST(DepthCoding, VectorsOfBothWidthsGiveTheSame) {
  Map narrow = random_map(1000, 9000);
  Map wide = narrow;
  DepthCoding coding;
  ASSERT_TRUE(choose_depth_coding(narrow.rho(), narrow.error(), narrow.inside(), focal_px, baseline, 16, coding).ok());
  std::vector<float> from_narrow(pixels), from_wide(pixels);
  use_vectors(VectorWidth::bytes16);
  ASSERT_TRUE(encode_depth(narrow.rho(), narrow.error(), narrow.inside(), coding, narrow.out()).ok());
  ASSERT_TRUE(decode_depth(narrow.out(), coding, {from_narrow.data(), width, height}).ok());
  use_vectors(widest_vectors());
  ASSERT_TRUE(encode_depth(wide.rho(), wide.error(), wide.inside(), coding, wide.out()).ok());
  ASSERT_TRUE(decode_depth(wide.out(), coding, {from_wide.data(), width, height}).ok());
  EXPECT_EQ(narrow.codes, wide.codes);
  EXPECT_EQ(from_narrow, from_wide);
}

TEST(DepthCoding, NothingValidGivesZeroCodes) {
  Map m;
  DepthCoding coding;
  ASSERT_TRUE(choose_depth_coding(m.rho(), m.error(), m.inside(), focal_px, baseline, 16, coding).ok());
  ASSERT_TRUE(encode_depth(m.rho(), m.error(), m.inside(), coding, m.out()).ok());
  for (const std::uint16_t code : m.codes) ASSERT_EQ(code, 0);
}

TEST(DepthCoding, WhereNothingWasKnownNothingIsKnownAfterDecoding) {
  Map m = random_map(80, 120);
  DepthCoding coding;
  ASSERT_TRUE(choose_depth_coding(m.rho(), m.error(), m.inside(), focal_px, baseline, 16, coding).ok());
  ASSERT_NE(coding.offset, 0);
  ASSERT_TRUE(encode_depth(m.rho(), m.error(), m.inside(), coding, m.out()).ok());
  std::vector<float> back(pixels, 7);
  ASSERT_TRUE(decode_depth(m.out(), coding, {back.data(), width, height}).ok());
  for (std::size_t i = 0; i < pixels; ++i) ASSERT_EQ(back[i] > 0, m.mask[i] != 0 && m.sigma[i] > 0) << i;
}

TEST(DepthCoding, RefusesForeignRangesCodesAndParameters) {
  Map near = random_map(10, 12);
  Map far = random_map(80, 120);
  DepthCoding coding;
  ASSERT_TRUE(choose_depth_coding(far.rho(), far.error(), far.inside(), focal_px, baseline, 16, coding).ok());
  EXPECT_EQ(encode_depth(near.rho(), near.error(), near.inside(), coding, near.out()).code,
            StatusCode::capacity_exceeded);
  std::vector<float> back(pixels);
  far.codes.assign(pixels, 0);
  far.codes[1234] = 1 << 13;
  const Status status = decode_depth(far.out(), coding, {back.data(), width, height});
  EXPECT_EQ(status.code, StatusCode::parse_error);
  EXPECT_EQ(status.a, 1234);
  EXPECT_EQ(choose_depth_coding(far.rho(), far.error(), far.inside(), 0, baseline, 16, coding).code,
            StatusCode::invalid_argument);
  EXPECT_EQ(encode_depth(far.rho(), far.error(), far.inside(), {0, 0}, far.out()).code, StatusCode::invalid_argument);
}

}  // namespace
}  // namespace ilp
