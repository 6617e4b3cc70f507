// The ordering constraint against an exhaustive search over all subsets.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/semi_global/ordering_filter.hpp"

namespace ilp {
namespace {

std::vector<float> kept(const std::vector<float>& disparity, std::vector<float> sigma) {
  static auto workspace = std::make_unique<OrderingWorkspace>();
  keep_ordered_row(static_cast<std::int32_t>(disparity.size()), disparity.data(), sigma.data(), *workspace);
  return sigma;
}

int count(const std::vector<float>& sigma) {
  int n = 0;
  for (const float s : sigma) n += s > 0 ? 1 : 0;
  return n;
}

bool ordered(const std::vector<float>& disparity, const std::vector<float>& sigma) {
  double last = -1e9;
  for (std::size_t x = 0; x < disparity.size(); ++x) {
    if (!(sigma[x] > 0)) continue;
    const double right = std::floor(static_cast<double>(x) - static_cast<double>(disparity[x]) + 0.5);
    if (right < last) return false;
    last = right;
  }
  return true;
}

TEST(OrderingFilter, SmoothTerrainIsLeftAlone) {
  std::vector<float> disparity;
  for (int x = 0; x < 300; ++x) disparity.push_back(20 + 8 * static_cast<float>(std::sin(x / 40.0)));
  const std::vector<float> sigma(300, 0.1F);
  EXPECT_EQ(kept(disparity, sigma), sigma);
}

TEST(OrderingFilter, AFalseMatchInTheMiddleGoesAndItsNeighboursStay) {
  std::vector<float> disparity(100, 10);
  for (int x = 50; x < 56; ++x) disparity[static_cast<std::size_t>(x)] = 40;  // lands behind 30 columns to the left
  const std::vector<float> sigma = kept(disparity, std::vector<float>(100, 0.1F));
  for (std::size_t x = 0; x < 100; ++x) EXPECT_EQ(sigma[x] > 0, x < 50 || x >= 56) << x;
}

TEST(OrderingFilter, InvalidPixelsStayInvalidAndDoNotCount) {
  std::vector<float> disparity(20, 5);
  std::vector<float> sigma(20, 0.1F);
  disparity[10] = 500;
  sigma[10] = 0;
  EXPECT_EQ(kept(disparity, sigma), sigma);
}

TEST(OrderingFilter, KeepsAsManyAsAnyOrderedSubset) {
  Rng rng(7);
  constexpr std::size_t width = 12;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<float> disparity;
    std::vector<float> sigma;
    for (std::size_t x = 0; x < width; ++x) {
      disparity.push_back(static_cast<float>(rng.uniform() * 10));
      sigma.push_back(rng.below(5) == 0 ? 0.0F : 0.2F);
    }
    int best = 0;
    for (std::uint32_t subset = 0; subset < (1U << width); ++subset) {
      std::vector<float> chosen = sigma;
      for (std::size_t x = 0; x < width; ++x) {
        if ((subset >> x & 1U) == 0) chosen[x] = 0;
      }
      if (count(chosen) > best && ordered(disparity, chosen)) best = count(chosen);
    }
    const std::vector<float> result = kept(disparity, sigma);
    EXPECT_TRUE(ordered(disparity, result));
    EXPECT_EQ(count(result), best);
  }
}

TEST(OrderingFilter, MatchesFarOutsideTheImageDoNotLeaveTheTable) {
  const std::vector<float> disparity = {-1e6F, 1e6F, 0, 3};
  EXPECT_TRUE(count(kept(disparity, std::vector<float>(4, 0.1F))) >= 2);
}

}  // namespace
}  // namespace ilp
