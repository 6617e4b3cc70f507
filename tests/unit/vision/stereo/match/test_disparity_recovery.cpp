// Gaps are filled by measuring there, not by copying from around them.
#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/match/disparity_recovery.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

constexpr std::int32_t width = 80;
constexpr std::int32_t height = 60;
constexpr std::int32_t gap_begin = 30;
constexpr std::int32_t gap_end = 36;

bool in_gap(std::int32_t x, std::int32_t y) {
  return x >= gap_begin && x < gap_end && y >= gap_begin && y < gap_end;
}

/// Textured ground at a disparity of 10 px, known everywhere but in a square gap.
class DisparityRecovery : public ::testing::Test {
 protected:
  DisparityRecovery() {
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        left.view().at(x, y) = grey(x, y);
        right.view().at(x, y) = grey(x + 10, y);
        if (in_gap(x, y)) sigma[index(x, y)] = 0;
      }
    }
    rows.left = left.view();
    rows.right = right.view();
    rows.left_valid = {valid.data(), width, height};
    rows.right_valid = {right_valid.data(), width, height};
    rows.radius = 2;
    rows.damping = 25;
  }

  static std::uint8_t grey(double x, double y) { return static_cast<std::uint8_t>(fractal_texture(x, y, 3, 5)); }
  static std::size_t index(std::int32_t x, std::int32_t y) { return static_cast<std::size_t>(y * width + x); }
  void recover() {
    for (std::int32_t y = 0; y < height; ++y) {
      recover_row(rows, {0, 31}, params, y, {disparity.data(), width, height}, {sigma.data(), width, height});
    }
  }
  template <typename Predicate>
  int count_in_gap(Predicate predicate) const {
    int count = 0;
    for (std::int32_t y = gap_begin; y < gap_end; ++y) {
      for (std::int32_t x = gap_begin; x < gap_end; ++x) count += predicate(index(x, y)) ? 1 : 0;
    }
    return count;
  }
  int valid_in_gap() const {
    return count_in_gap([this](std::size_t i) { return sigma[i] > 0; });
  }

  Image left{width, height};
  Image right{width, height};
  std::vector<std::uint8_t> valid = std::vector<std::uint8_t>(width * height, 255);
  std::vector<std::uint8_t> right_valid = valid;
  std::vector<float> disparity = std::vector<float>(width * height, 10.0F);
  std::vector<float> sigma = std::vector<float>(width * height, 0.1F);
  NccRows rows;
  StereoParams params;
};

constexpr int gap_pixels = (gap_end - gap_begin) * (gap_end - gap_begin);

TEST_F(DisparityRecovery, AGapInTexturedGroundIsMeasured) {
  for (std::size_t i = 0; i < disparity.size(); ++i) {
    if (!(sigma[i] > 0)) disparity[i] = -7;
  }
  recover();
  EXPECT_EQ(valid_in_gap(), gap_pixels);
  EXPECT_EQ(count_in_gap([this](std::size_t i) { return std::fabs(disparity[i] - 10) < 0.4F; }), gap_pixels);
}

TEST_F(DisparityRecovery, WhatIsFoundIsTheImagesDisparityNotTheNeighbours) {
  // The neighbours say 10.4, the images 10.
  std::fill(disparity.begin(), disparity.end(), 10.4F);
  recover();
  EXPECT_GT(count_in_gap([this](std::size_t i) { return sigma[i] > 0 && std::fabs(disparity[i] - 10) < 0.4F; }),
            0.9 * gap_pixels);
}

TEST_F(DisparityRecovery, WhatContradictsTheNeighboursIsNotTaken) {
  std::fill(disparity.begin(), disparity.end(), 11.0F);
  recover();
  EXPECT_EQ(count_in_gap([this](std::size_t i) { return sigma[i] > 0 && std::fabs(disparity[i] - 11) > 0.6F; }), 0);
  EXPECT_LT(valid_in_gap(), 0.2 * gap_pixels);
}

TEST_F(DisparityRecovery, WhereTheOtherImageShowsSomethingElseTheGapStays) {
  Rng rng(5);
  for (std::int32_t y = gap_begin - 4; y < gap_end + 4; ++y) {
    for (std::int32_t x = gap_begin - 16; x < gap_end - 6; ++x) {
      right.view().at(x, y) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  // A chance correlation of 0.5 in a window of 25 pixels is rare, one of 0.2 is not.
  params.recovery_min_ncc = 0.5;
  recover();
  EXPECT_LT(valid_in_gap(), 0.1 * gap_pixels);
}

TEST_F(DisparityRecovery, BlankGroundStaysUnknown) {
  for (std::int32_t y = gap_begin - 4; y < gap_end + 4; ++y) {
    for (std::int32_t x = gap_begin - 4; x < gap_end + 4; ++x) left.view().at(x, y) = right.view().at(x - 10, y) = 90;
  }
  recover();
  EXPECT_EQ(valid_in_gap(), 0);
}

TEST_F(DisparityRecovery, TextureTooFaintToBeTrustedStaysUnknownHoweverWellItCorrelates) {
  const auto lay = [this](std::int32_t step) {
    Rng rng(9);
    for (std::int32_t y = gap_begin - 4; y < gap_end + 4; ++y) {
      for (std::int32_t x = gap_begin - 4; x < gap_end + 4; ++x) {
        left.view().at(x, y) = right.view().at(x - 10, y) =
            static_cast<std::uint8_t>(90 + step * static_cast<std::int32_t>(rng.below(2)));
      }
    }
  };
  // Hardly any noise: one grey level correlates perfectly, but deviates by half a level only.
  rows.damping = 0.1F;
  lay(1);
  recover();
  EXPECT_EQ(valid_in_gap(), 0);
  lay(2);
  recover();
  EXPECT_GT(valid_in_gap(), 0.9 * gap_pixels) << "the same texture twice as strong must be found";
}

TEST_F(DisparityRecovery, NothingIsMeasuredOutOfViewOrBeyondTheRange) {
  const auto stays = [this] {
    recover();
    const int found = valid_in_gap();
    for (std::size_t i = 0; i < sigma.size(); ++i) {
      if (in_gap(static_cast<std::int32_t>(i) % width, static_cast<std::int32_t>(i) / width)) sigma[i] = 0;
    }
    return found == 0;
  };
  std::fill(right_valid.begin(), right_valid.end(), std::uint8_t{0});
  EXPECT_TRUE(stays());
  std::fill(right_valid.begin(), right_valid.end(), std::uint8_t{255});
  std::fill(valid.begin(), valid.end(), std::uint8_t{0});
  EXPECT_TRUE(stays());
  std::fill(valid.begin(), valid.end(), std::uint8_t{255});
  std::fill(disparity.begin(), disparity.end(), 31.0F);
  EXPECT_TRUE(stays());
  std::fill(disparity.begin(), disparity.end(), 10.0F);
  params.recovery_neighbours = 0;
  EXPECT_TRUE(stays());
}

TEST_F(DisparityRecovery, NeighboursThatContradictEachOtherProposeNothing) {
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) disparity[index(x, y)] = static_cast<float>(4 + 4 * ((x + 2 * y) % 5));
  }
  recover();
  EXPECT_EQ(valid_in_gap(), 0);
}

}  // namespace
}  // namespace ilp::test
