// PCG32 against the author's reference output, and the distributions made from it.
#include "fsw/base/rng.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace ilp {
namespace {

TEST(Mix64, IsSplitMix64) {
  // First outputs of SplitMix64 seeded with 0 (S. Vigna's reference: state advances by the golden gamma, then is
  // mixed).
  EXPECT_EQ(mix64(0), 0xE220A8397B1DCDAFULL);
  EXPECT_EQ(mix64(0x9E3779B97F4A7C15ULL), 0x6E789E6AA1B965F4ULL);
}

/// pcg32_random_r of the minimal C implementation (M. E. O'Neill), written independently of the class.
struct ReferencePcg {
  std::uint64_t state, increment;
  std::uint32_t next() {
    const std::uint64_t old = state;
    state = old * 6364136223846793005ULL + increment;
    const auto x = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
    const auto r = static_cast<std::uint32_t>(old >> 59U);
    return (x >> r) | (x << ((0U - r) & 31U));
  }
};

TEST(Rng, ReferenceReproducesThePublishedSequence) {
  // pcg32-demo: seed 42, stream 54.
  ReferencePcg pcg{0, (54U << 1U) | 1U};
  pcg.next();
  pcg.state += 42;
  pcg.next();
  for (const std::uint32_t expected : {0xA15C02B7U, 0x7B47F409U, 0xBA1D3330U, 0x83D2F293U, 0xBFA4784BU, 0xCBED606EU}) {
    EXPECT_EQ(pcg.next(), expected);
  }
}

TEST(Rng, IsPcg32WithMixedSeeds) {
  Rng rng(42, 54);
  ReferencePcg pcg{0, (mix64(54) << 1U) | 1U};
  pcg.next();
  pcg.state += mix64(42);
  pcg.next();
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(rng.next(), pcg.next());
}

TEST(Rng, SeedsAndStreamsDiffer) {
  Rng a(1);
  Rng b(2);
  Rng c(1, 1);
  int equal = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::uint32_t x = a.next();
    equal += x == b.next() ? 1 : 0;
    equal += x == c.next() ? 1 : 0;
  }
  EXPECT_LE(equal, 1);
}

TEST(Rng, BelowIsUniformAndBelow) {
  Rng rng(7);
  std::array<int, 10> histogram{};
  constexpr int draws = 100000;
  for (int i = 0; i < draws; ++i) {
    const std::uint32_t x = rng.below(10);
    ASSERT_LT(x, 10U);
    ++histogram[x];
  }
  double chi2 = 0;
  for (const int count : histogram) chi2 += (count - draws / 10.0) * (count - draws / 10.0) / (draws / 10.0);
  EXPECT_LT(chi2, 27.9);  // 0.999 quantile of 9 degrees of freedom
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rng.below(1), 0U);
}

TEST(Rng, UniformCoversTheHalfOpenInterval) {
  Rng rng(3);
  double sum = 0;
  double sum2 = 0;
  constexpr int draws = 100000;
  for (int i = 0; i < draws; ++i) {
    const double x = rng.uniform();
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / draws, 0.5, 0.004);
  EXPECT_NEAR(sum2 / draws, 1.0 / 3, 0.004);
}

}  // namespace
}  // namespace ilp
