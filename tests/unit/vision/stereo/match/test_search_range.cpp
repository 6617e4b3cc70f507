// Coarse to fine: the narrowed search finds what a search of the whole range finds.
#include "fsw/vision/stereo/cost/search_range.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

constexpr std::int32_t width = 320;
constexpr std::int32_t height = 256;
constexpr DisparityRange range{0, 63};

/// A coarse map of one disparity, matched everywhere.
struct Map {
  std::int32_t w = width / 4;
  std::int32_t h = height / 4;
  std::vector<float> disparity = std::vector<float>(static_cast<std::size_t>(w * h), 5.0F);
  std::vector<float> sigma = std::vector<float>(disparity.size(), 0.1F);
  std::vector<std::uint8_t> valid = std::vector<std::uint8_t>(disparity.size(), 1);

  [[nodiscard]] CoarseMap view() const {
    return {{disparity.data(), w, h}, {sigma.data(), w, h}, {valid.data(), w, h}};
  }
  [[nodiscard]] std::size_t at(std::int32_t x, std::int32_t y) const { return static_cast<std::size_t>(y * w + x); }
};

const SearchRun& run_at(const SearchRow& row, std::int32_t x) {
  for (const SearchRun& run : row) {
    if (x >= run.begin && x < run.end) return run;
  }
  ADD_FAILURE() << "no run at column " << x;
  return *row.begin();
}

TEST(SearchRange, LevelGroundNeedsOneBlockAroundItsDisparity) {
  const Map map;
  const SearchRow row = search_of_band(map.view(), width, 2, range);
  ASSERT_EQ(row.size, 1);
  EXPECT_EQ(row.begin()->begin, 0);
  EXPECT_EQ(row.begin()->end, width);
  EXPECT_EQ(row.begin()->count, disparity_block);
  // 5 px at a quarter of the resolution are 20 px.
  EXPECT_LE(row.begin()->first, 20 - search_margin_px);
  EXPECT_GE(row.begin()->first + row.begin()->count, 21 + search_margin_px);
}

TEST(SearchRange, RunsCoverEveryColumnOnceAndStayInTheRange) {
  Map map;
  for (std::int32_t y = 0; y < map.h; ++y) {
    for (std::int32_t x = 0; x < map.w; ++x) map.disparity[map.at(x, y)] = static_cast<float>((x * 7 + y * 3) % 16);
  }
  constexpr std::int32_t odd_width = width - 7;
  for (std::int32_t band = 0; band < height / search_tile; ++band) {
    std::int32_t next = 0;
    for (const SearchRun& run : search_of_band(map.view(), odd_width, band, range)) {
      EXPECT_EQ(run.begin, next);
      EXPECT_GE(run.first, 0);
      EXPECT_LE(run.first + run.count, whole_blocks(range.count()));
      EXPECT_EQ(run.count % disparity_block, 0);
      next = run.end;
    }
    EXPECT_EQ(next, odd_width);
  }
}

TEST(SearchRange, CliffIsSearchedOnBothItsSidesAndBesideItsTile) {
  Map map;
  for (std::int32_t y = 0; y < map.h; ++y) {
    for (std::int32_t x = 42; x < map.w; ++x) map.disparity[map.at(x, y)] = 12;
  }
  const SearchRow row = search_of_band(map.view(), width, 3, range);
  // The edge at column 168 is in the tile of columns 160 to 191, two columns of the map from the tile before.
  for (const std::int32_t x : {140, 159, 168, 190}) {
    const SearchRun& run = run_at(row, x);
    EXPECT_LE(run.first, 20) << x;
    EXPECT_GE(run.first + run.count, 49) << x;
  }
  EXPECT_EQ(run_at(row, 40).count, disparity_block);
  EXPECT_EQ(run_at(row, 300).count, disparity_block);
}

TEST(SearchRange, WhatTheCoarseMapCouldNotMatchIsSearchedInFull) {
  Map map;
  for (std::int32_t y = 8; y < 16; ++y) {
    for (std::int32_t x = 24; x < 30; ++x) map.sigma[map.at(x, y)] = 0;
  }
  const SearchRow row = search_of_band(map.view(), width, 1, range);
  EXPECT_EQ(run_at(row, 100).count, 64);
  EXPECT_EQ(run_at(row, 200).count, disparity_block);
}

TEST(SearchRange, MaskedGroundIsNotUnmatchedGround) {
  Map map;
  for (std::int32_t y = 8; y < 16; ++y) {
    for (std::int32_t x = 24; x < 30; ++x) {
      map.sigma[map.at(x, y)] = 0;
      map.valid[map.at(x, y)] = 0;
    }
  }
  EXPECT_EQ(run_at(search_of_band(map.view(), width, 1, range), 100).count, disparity_block);
}

/// Ground at 20 px with a slope, and boulders of `boulder_px` that stand out by `step_px`.
struct Boulders {
  std::int32_t side_px;
  double step_px;

  [[nodiscard]] bool inside(double x, double y) const {
    return std::fmod(x, 64) >= 40 && std::fmod(x, 64) < 40 + side_px && std::fmod(y, 64) >= 20 &&
           std::fmod(y, 64) < 20 + side_px;
  }
  [[nodiscard]] double disparity(double x, double y) const { return 20 + 0.02 * x + (inside(x, y) ? step_px : 0); }
};

struct Found {
  double valid = 0, wrong = 0;  ///< of the pixels well inside the boulders
};

Found match_boulders(const Boulders& boulders, bool coarse_to_fine) {
  Image left(width, height);
  Image right(width, height);
  for (std::int32_t y = 0; y < height; ++y) {
    // Nearest surface first: the right image sees the left pixel with the larger disparity.
    std::vector<double> nearest(static_cast<std::size_t>(width), -1);
    for (std::int32_t x = 0; x < width; ++x) {
      left.view().at(x, y) = static_cast<std::uint8_t>(fractal_texture(x, y, 3, 5));
      right.view().at(x, y) = static_cast<std::uint8_t>(fractal_texture(x + 20, y + 500, 3, 5));
    }
    for (double x = 0; x < width; x += 0.125) {
      const double d = boulders.disparity(x, y);
      const auto u = static_cast<std::int32_t>(std::lround(x - d));
      if (u < 0 || u >= width || d < nearest[static_cast<std::size_t>(u)]) continue;
      nearest[static_cast<std::size_t>(u)] = d;
      right.view().at(u, y) = static_cast<std::uint8_t>(fractal_texture(u + d, y, 3, 5));
    }
  }
  static const auto workspace = std::make_unique<StereoWorkspace>();
  const std::vector<std::uint8_t> whole(left.pixels.size(), 1);
  std::vector<float> disparity(left.pixels.size());
  std::vector<float> sigma(left.pixels.size());
  StereoParams params{.coarse_to_fine = coarse_to_fine};
  StereoMatcher matcher;
  const Status begun =
      matcher.begin(left.view(), right.view(), {whole.data(), width, height}, {whole.data(), width, height}, range,
                    params, *workspace, {{disparity.data(), width, height}, {sigma.data(), width, height}});
  EXPECT_TRUE(begun.ok() && do_all([&] { return matcher.step(32); }).ok());
  Found found;
  double all = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 100; x < width; ++x) {
      if (!boulders.inside(x - 3, y - 3) || !boulders.inside(x + 3, y + 3)) continue;
      const auto i = static_cast<std::size_t>(y * width + x);
      ++all;
      if (!(sigma[i] > 0)) continue;
      ++found.valid;
      if (std::fabs(static_cast<double>(disparity[i]) - boulders.disparity(x, y)) > 1) ++found.wrong;
    }
  }
  found.valid /= all;
  found.wrong /= all;
  std::printf("boulders of %d px standing out by %.0f px, %s: %.1f %% valid, %.1f %% wrong\n", boulders.side_px,
              boulders.step_px, coarse_to_fine ? "coarse to fine" : "whole range", 100 * found.valid,
              100 * found.wrong);
  return found;
}

class NarrowedSearch : public ::testing::TestWithParam<Boulders> {};

TEST_P(NarrowedSearch, LosesNoBoulders) {
  const Found whole = match_boulders(GetParam(), false);
  const Found narrowed = match_boulders(GetParam(), true);
  EXPECT_GT(whole.valid, 0.8);
  EXPECT_GE(narrowed.valid, whole.valid - 0.02);
  EXPECT_LE(narrowed.wrong, whole.wrong + 0.02);
}

INSTANTIATE_TEST_SUITE_P(Boulders, NarrowedSearch,
                         ::testing::Values(Boulders{12, 4}, Boulders{12, 8}, Boulders{16, 10}, Boulders{20, 24},
                                           Boulders{24, 24}),
                         [](const auto& test) {
                           return std::to_string(test.param.side_px) + "PxStandingOutBy" +
                                  std::to_string(static_cast<int>(test.param.step_px));
                         });

}  // namespace
}  // namespace ilp::test
