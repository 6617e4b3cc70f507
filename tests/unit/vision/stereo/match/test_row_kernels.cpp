// Correlations and fits of a row against the formulas, written out pixel by pixel, with vectors of either width.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/match/disparity_selection.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

class RowKernels : public ::testing::TestWithParam<VectorWidth> {
 protected:
  ~RowKernels() override { use_vectors(widest_vectors()); }
  void SetUp() override {
    if (GetParam() == VectorWidth::bytes32 && widest_vectors() == VectorWidth::bytes16) {
      GTEST_SKIP() << "this processor has vectors of 16 bytes only";
    }
    use_vectors(GetParam());
  }
};
INSTANTIATE_TEST_SUITE_P(Widths, RowKernels, ::testing::Values(VectorWidth::bytes16, VectorWidth::bytes32));

/// The correlation of two windows, whose pixels outside the image repeat its border.
double correlation(const Image& left, const Image& right, std::int32_t x, std::int32_t y, std::int32_t d,
                   std::int32_t radius, double damping) {
  const auto at = [](const Image& image, std::int32_t u, std::int32_t v) -> double {
    return image.view().at(std::clamp(u, 0, image.width - 1), std::clamp(v, 0, image.height - 1));
  };
  const double n = (2 * radius + 1) * (2 * radius + 1);
  double l = 0, r = 0, ll = 0, rr = 0, lr = 0;
  for (std::int32_t v = y - radius; v <= y + radius; ++v) {
    for (std::int32_t u = x - radius; u <= x + radius; ++u) {
      const double a = at(left, u, v), b = at(right, u - d, v);
      l += a;
      r += b;
      ll += a * a;
      rr += b * b;
      lr += a * b;
    }
  }
  return (lr - l * r / n) / std::sqrt((ll - l * l / n + damping) * (rr - r * r / n + damping));
}

TEST_P(RowKernels, CorrelationsAndCostsAreThoseOfTheFormulaAlsoWhereTheSearchChanges) {
  constexpr std::int32_t width = 83, height = 21, min_disparity = -3;
  Rng rng(5);
  Image left(width, height), right(width, height);
  for (auto* image : {&left, &right}) {
    for (auto& grey : image->pixels) grey = static_cast<std::uint8_t>(255.9 * rng.uniform());
  }
  std::vector<std::uint8_t> left_valid(left.pixels.size(), 1), right_valid(left_valid);
  for (auto* valid : {&left_valid, &right_valid}) {
    for (auto& v : *valid) v = rng.uniform() < 0.1 ? 0 : 1;
  }
  const auto workspace = std::make_unique<NccWorkspace>();
  for (const std::int32_t radius : {1, 2, 4}) {
    NccRows rows;
    rows.left = left.view();
    rows.right = right.view();
    rows.left_valid = {left_valid.data(), width, height};
    rows.right_valid = {right_valid.data(), width, height};
    rows.min_disparity = min_disparity;
    rows.padded_disparities = 80;
    rows.radius = radius;
    rows.damping = 9;
    rows.out_of_view_cost = 30;
    std::vector<std::int16_t> ncc(static_cast<std::size_t>(width * rows.padded_disparities));
    std::vector<std::uint8_t> cost(ncc.size());
    std::vector<float> variance(width);
    for (std::int32_t y = 0; y < height; ++y) {
      SearchRow search;
      search.runs[0] = {0, 30, 16, y < 9 ? 16 : 32};
      search.runs[1] = {30, 64, 0, 80};
      search.runs[2] = {64, width, 32, 48};
      search.size = 3;
      compute_ncc_row(rows, search, *workspace, ncc.data(), cost.data(), variance.data());
      for (const SearchRun& run : search) {
        for (std::int32_t x = run.begin; x < run.end; ++x) {
          for (std::int32_t i = run.first; i < run.first + run.count; ++i) {
            const std::int32_t target = x - (min_disparity + i);
            const bool in_left = rows.left_valid.at(x, y) != 0;
            const bool in_right = target >= 0 && target < width && rows.right_valid.at(target, y) != 0;
            const double expected =
                in_left && in_right ? correlation(left, right, x, y, min_disparity + i, radius, 9) : 0;
            const auto k = static_cast<std::size_t>(x * rows.padded_disparities + i);
            ASSERT_NEAR(ncc[k], ncc_one * expected, 1.5) << x << " " << y << " " << i;
            const double paid = in_right ? max_matching_cost * (1 - std::max(expected, 0.0)) : 30;
            ASSERT_NEAR(cost[k], in_left ? paid : 0, 0.51) << x << " " << y << " " << i;
          }
        }
      }
    }
  }
}

/// Pixels of a row that chose one disparity over several columns, and beside them others.
TEST_P(RowKernels, AFitIsThatOfTheCorrelationsSummedOverThePixelAndTheTwoOnEitherSide) {
  constexpr std::int32_t width = 90, padded = 32;
  Rng rng(11);
  NccRows rows;
  const Image grey(width, 1);
  std::vector<std::uint8_t> valid(width, 1);
  valid[50] = 0;
  rows.left = rows.right = grey.view();
  rows.left_valid = rows.right_valid = {valid.data(), width, 1};
  rows.padded_disparities = padded;
  rows.radius = 2;
  rows.damping = 25;
  rows.search = search_everything(width, padded);
  std::vector<std::int16_t> spare(static_cast<std::size_t>(padded * width + 32), 0);
  std::int16_t* ncc = spare.data() + 16;
  for (std::int32_t i = 0; i < padded * width; ++i) ncc[i] = static_cast<std::int16_t>(1 + 9000 * rng.uniform());
  std::vector<RowWinner> winners(width);
  for (std::int32_t x = 0; x < width; ++x) {
    const auto d = static_cast<std::int16_t>(x < 41 ? 12 : x < 60 ? 11 : 4);
    winners[static_cast<std::size_t>(x)] = {100, d, true};
    ncc[padded * x + d] = static_cast<std::int16_t>(10000 + 6000 * rng.uniform());
  }
  ncc[padded * 30 + 12] = 0;
  const std::vector<float> variance(width, 100);
  std::vector<float> disparity(width), sigma(width);
  const auto workspace = std::make_unique<SelectionWorkspace>();
  select_row(rows, 0, padded, {}, ncc, winners.data(), variance.data(), *workspace, disparity.data(), sigma.data());
  int compared = 0;
  for (std::int32_t x = 2; x < width - 2; ++x) {
    const auto k = static_cast<std::size_t>(x);
    if (x == 30 || x == 50) {
      EXPECT_EQ(sigma[k], 0) << x;
      continue;
    }
    // Beside a pixel that is not in view, or a step of more than one, the support is smaller.
    if (std::abs(x - 30) <= 2 || std::abs(x - 59.5) < 2) continue;
    const std::int32_t d = winners[k].index;
    double before = 0, at = 0, after = 0;
    for (std::int32_t u = x - 2; u <= x + 2; ++u) {
      before += ncc[padded * u + d - 1];
      at += ncc[padded * u + d];
      after += ncc[padded * u + d + 1];
    }
    ASSERT_GT(sigma[k], 0) << x;
    const double vertex = 0.5 * (after - before) / (2 * at - before - after);
    EXPECT_NEAR(disparity[k], d + std::clamp(vertex, -0.5, 0.5), 1e-4) << x;
    ++compared;
  }
  EXPECT_GT(compared, 70);
}

}  // namespace
}  // namespace ilp::test
