#include "fsw/products/index_ranks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

TEST(IndexRanksTest, FewerThanTenImagesRankInTheMiddle) {
  IndexRanks ranks;
  for (std::uint32_t i = 0; i < IndexRanks::fewest_images; ++i) {
    EXPECT_EQ(ranks.rank(0), 0.5);
    EXPECT_EQ(ranks.rank(1), 0.5);
    ranks.add(0.3 + 0.01 * i);
  }
  EXPECT_EQ(ranks.rank(0.2), 0);
  EXPECT_EQ(ranks.rank(0.6), 1);
  EXPECT_DOUBLE_EQ(ranks.rank(0.3), 0.05) << "its own bin counts half";
}

TEST(IndexRanksTest, ARankIsTheShareOfLowerIndicesAndNeverFallsWithTheIndex) {
  Rng rng(7);
  IndexRanks ranks;
  std::vector<double> indices;
  for (int i = 0; i < 500; ++i) {
    const double index = 0.3 + 0.45 * rng.uniform() * rng.uniform();
    ranks.add(index);
    indices.push_back(index);
  }
  std::sort(indices.begin(), indices.end());
  double before = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double index = i / 1000.0;
    const double rank = ranks.rank(index);
    EXPECT_GE(rank, before);
    before = rank;
    const auto lower = std::lower_bound(indices.begin(), indices.end(), index) - indices.begin();
    // A bin is 1/256 wide.
    const auto in_bin = std::lower_bound(indices.begin(), indices.end(), index + 1.0 / IndexRanks::bins) -
                        std::lower_bound(indices.begin(), indices.end(), index - 1.0 / IndexRanks::bins);
    EXPECT_NEAR(rank, static_cast<double>(lower) / 500, static_cast<double>(in_bin) / 500 + 1e-9) << index;
  }
}

TEST(IndexRanksTest, IndicesThatAreNoneAreCountedAtTheEnds) {
  IndexRanks ranks;
  for (int i = 0; i < 5; ++i) {
    ranks.add(-1);
    ranks.add(2);
  }
  EXPECT_EQ(ranks.rank(0.5), 0.5);
  EXPECT_EQ(ranks.rank(0), 0.25);
  EXPECT_EQ(ranks.rank(1), 0.75);
}

TEST(IndexRanksTest, ALongFlightForgetsWhatItSawFirst) {
  IndexRanks ranks;
  for (int i = 0; i < 20000; ++i) ranks.add(0.6);
  EXPECT_EQ(ranks.rank(0.5), 0);
  for (int i = 0; i < 20000; ++i) ranks.add(0.4);
  EXPECT_GT(ranks.rank(0.5), 0.99);
}

}  // namespace
}  // namespace ilp
