// The ordered matcher on images whose disparities, occlusions and order are known by construction.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

struct Answer {
  Status status;
  std::int32_t width = 0;
  std::vector<float> disparity_px, sigma_px;

  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y * width + x);
  }
  [[nodiscard]] bool valid(std::int32_t x, std::int32_t y) const { return sigma_px[index(x, y)] > 0; }
  [[nodiscard]] double at(std::int32_t x, std::int32_t y) const {
    return static_cast<double>(disparity_px[index(x, y)]);
  }
  [[nodiscard]] std::ptrdiff_t count() const {
    return std::count_if(sigma_px.begin(), sigma_px.end(), [](float s) { return s > 0; });
  }
};

Answer match(const Image& left, const Image& right, const DisparityRange& range) {
  static const auto workspace = std::make_unique<StereoWorkspace>();
  Answer a{{}, left.width, std::vector<float>(left.pixels.size()), std::vector<float>(left.pixels.size())};
  const std::vector<std::uint8_t> everywhere(left.pixels.size(), 1);
  const MaskView mask(everywhere.data(), left.width, left.height);
  StereoParams params{.matcher = StereoMatcherChoice::ordered_scanline};
  StereoMatcher matcher;
  a.status =
      matcher.begin(left.view(), right.view(), mask, mask, range, params, *workspace,
                    {{a.disparity_px.data(), left.width, left.height}, {a.sigma_px.data(), left.width, left.height}});
  if (a.status.ok()) a.status = do_all([&] { return matcher.step(32); });
  return a;
}

std::uint8_t ground(double x, double y) {
  return static_cast<std::uint8_t>(std::clamp(128 + 2 * (fractal_texture(x, y, 3, 5) - 128), 0.0, 255.0));
}

Image mirrored(const Image& image) {
  Image out(image.width, image.height);
  for (std::int32_t y = 0; y < image.height; ++y) {
    for (std::int32_t x = 0; x < image.width; ++x) out.view().at(x, y) = image.view().at(image.width - 1 - x, y);
  }
  return out;
}

/// A plateau with vertical walls above level ground; rows shift the walls a little.
struct Plateau {
  static constexpr std::int32_t width = 360, height = 160;
  static constexpr double low = 12, high = 27;
  Image left{width, height}, right{width, height};

  static double begin(std::int32_t y) { return 130 + 0.1 * y; }
  static double end(std::int32_t y) { return 250 - 0.05 * y; }
  static bool above(double x, std::int32_t y) { return x >= begin(y) && x < end(y); }
  static double disparity(double x, std::int32_t y) { return above(x, y) ? high : low; }
  /// The plateau hides this ground from the right camera.
  static bool hidden(double x, std::int32_t y) {
    return !above(x, y) && x - low >= begin(y) - high && x - low < end(y) - high;
  }
  /// The windows of pixels beside a wall show more of the other side; averaging reaches 2 px further.
  static bool at_wall(double x, std::int32_t y, double reach) {
    return std::min(std::fabs(x - begin(y)), std::fabs(x - end(y))) < reach;
  }
  Plateau() {
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        left.view().at(x, y) = above(x, y) ? ground(x + 900, y + 700) : ground(x, y);
        right.view().at(x, y) = above(x + high, y) ? ground(x + high + 900, y + 700) : ground(x + low, y);
      }
    }
  }
};

TEST(OrderedMatcher, AtAStepTheHiddenGroundIsInvalidAndTheRestIsRight) {
  const Plateau scene;
  const Answer a = match(scene.left, scene.right, {0, 47});
  ASSERT_TRUE(a.status.ok());
  int hidden = 0, hidden_valid = 0, open = 0, right = 0, wrong = 0;
  for (std::int32_t y = 4; y < Plateau::height - 4; ++y) {
    for (std::int32_t x = 60; x < Plateau::width - 4; ++x) {
      if (Plateau::hidden(x, y)) {
        ++hidden;
        hidden_valid += a.valid(x, y) ? 1 : 0;
        continue;
      }
      if (Plateau::at_wall(x, y, 3)) continue;
      ++open;
      if (!a.valid(x, y)) continue;
      (std::fabs(a.at(x, y) - Plateau::disparity(x, y)) < 0.5 ? right : wrong) += 1;
    }
  }
  std::printf("hidden: %.1f %% valid; open: %.2f %% right, %.2f %% wrong\n", 100.0 * hidden_valid / hidden,
              100.0 * right / open, 100.0 * wrong / open);
  EXPECT_GT(hidden, 2000);
  // Windows of 5 px reach beyond the wall.
  EXPECT_LT(hidden_valid, 0.2 * hidden);
  EXPECT_GT(right, 0.97 * open);
  EXPECT_LT(wrong, 0.01 * open);
}

/// Pairs of neighbouring valid pixels of a row whose order is not the same in both images.
int disordered(const Answer& a) {
  int count = 0;
  for (std::size_t row = 0; row < a.sigma_px.size(); row += static_cast<std::size_t>(a.width)) {
    double last = -1e9;
    for (std::int32_t x = 0; x < a.width; ++x) {
      const std::size_t i = row + static_cast<std::size_t>(x);
      if (!(a.sigma_px[i] > 0)) continue;
      const double right = std::floor(x - static_cast<double>(a.disparity_px[i]) + 0.5);
      count += right < last ? 1 : 0;
      last = std::max(last, right);
    }
  }
  return count;
}

TEST(OrderedMatcher, EveryRowKeepsTheOrderOfBothImages) {
  const Plateau scene;
  EXPECT_EQ(disordered(match(scene.left, scene.right, {0, 47})), 0);
  // Columns in front of far ground: no ordered answer has all of it.
  Image left = scene.left, right = scene.right;
  for (std::int32_t y = 0; y < left.height; ++y) {
    for (std::int32_t x = 40; x + 46 < left.width; x += 60) {
      for (std::int32_t k = 0; k < 6; ++k) {
        left.view().at(x + 40 + k, y) = right.view().at(x + k, y) = ground(k + 3000, y);
      }
    }
  }
  const Answer a = match(left, right, {0, 63});
  EXPECT_GT(a.count(), 0);
  EXPECT_EQ(disordered(a), 0);
}

TEST(OrderedMatcher, TheMirroredAndSwappedPairGivesTheMirroredAnswer) {
  const Plateau scene;
  const Answer a = match(scene.left, scene.right, {0, 47});
  const Answer b = match(mirrored(scene.right), mirrored(scene.left), {0, 47});
  int valid = 0, confirmed = 0, denied = 0;
  for (std::int32_t y = 4; y < Plateau::height - 4; ++y) {
    for (std::int32_t x = 60; x < Plateau::width - 60; ++x) {
      if (!a.valid(x, y) || Plateau::hidden(x, y) || Plateau::at_wall(x, y, 6)) continue;
      ++valid;
      const auto twin = static_cast<std::int32_t>(std::lround(Plateau::width - 1 - (x - a.at(x, y))));
      if (!b.valid(twin, y)) continue;
      (std::fabs(b.at(twin, y) - a.at(x, y)) < 0.1 ? confirmed : denied) += 1;
    }
  }
  std::printf("mirrored: %.2f %% confirmed, %.2f %% denied\n", 100.0 * confirmed / valid, 100.0 * denied / valid);
  // With the left pixel held alone, two thirds agree so well.
  EXPECT_GT(confirmed, 0.95 * valid);
  EXPECT_LT(denied, 0.05 * valid);
}

TEST(OrderedMatcher, AShiftIsFoundToAFractionOfAPixelAtEveryFraction) {
  constexpr std::int32_t width = 200, height = 61;  // not a multiple of the rows that are computed at once
  for (int tenth = 0; tenth < 10; ++tenth) {
    const double shift = 10 + 0.1 * tenth;
    Image left(width, height), right(width, height);
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        left.view().at(x, y) = ground(x, y);
        right.view().at(x, y) = ground(x + shift, y);
      }
    }
    const Answer a = match(left, right, {0, 31});
    double sum = 0, squares = 0;
    int count = 0;
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 16; x < width - 4; ++x) {
        if (!a.valid(x, y)) continue;
        sum += a.at(x, y) - shift;
        squares += (a.at(x, y) - shift) * (a.at(x, y) - shift);
        ++count;
      }
    }
    EXPECT_GT(count, 0.97 * height * (width - 20)) << shift;
    EXPECT_LT(std::fabs(sum / count), 0.03) << shift;
    EXPECT_LT(std::sqrt(squares / count), 0.1) << shift;
  }
}

TEST(OrderedMatcher, ImagesWithoutContentOrRoomGiveNothingAndNoFault) {
  const Image flat(120, 80);
  EXPECT_EQ(match(flat, flat, {0, 31}).count(), 0);
  Image row(200, 1), shifted(200, 1);
  for (std::int32_t x = 0; x < 200; ++x) {
    row.view().at(x, 0) = ground(x, 0);
    shifted.view().at(x, 0) = ground(x + 6, 0);
  }
  const Answer one_row = match(row, shifted, {0, 31});
  EXPECT_TRUE(one_row.status.ok());
  EXPECT_GT(one_row.count(), 150);
  for (std::int32_t x = 0; x < 200; ++x) {
    EXPECT_TRUE(!one_row.valid(x, 0) || std::fabs(one_row.at(x, 0) - 6) < 1) << x;
  }
  // A disparity at the end of the range may continue beyond it, so a range of one has no answer.
  const Answer one_disparity = match(row, shifted, {6, 6});
  EXPECT_TRUE(one_disparity.status.ok());
  EXPECT_EQ(one_disparity.count(), 0);
  const Answer one_column = match(Image(1, 40), Image(1, 40), {0, 15});
  EXPECT_TRUE(one_column.status.ok());
  EXPECT_EQ(one_column.count(), 0);
}

TEST(OrderedMatcher, TheLongestRangeIsSearched) {
  constexpr std::int32_t width = 420, height = 96;
  constexpr std::int32_t shift = limits::max_disparities - 20;
  Image left(width, height), right(width, height);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      left.view().at(x, y) = ground(x, y);
      right.view().at(x, y) = ground(x + shift, y);
    }
  }
  const Answer a = match(left, right, {0, limits::max_disparities - 1});
  ASSERT_TRUE(a.status.ok());
  int right_ones = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = shift + 8; x < width; ++x) right_ones += a.valid(x, y) && std::fabs(a.at(x, y) - shift) < 0.3;
  }
  EXPECT_GT(right_ones, 0.95 * height * (width - shift - 8));
}

}  // namespace
}  // namespace ilp::test
