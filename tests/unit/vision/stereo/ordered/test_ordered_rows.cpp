// The ordered path of a row against a search that states the problem in another way, and its properties.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/ordered/ordered_rows.hpp"
#include "fsw/vision/stereo/ordered/slope_steps.hpp"

namespace ilp {
namespace {

constexpr std::int32_t disparities = 16;
constexpr int unit = ncc_one / max_ordered_cost;

/// Correlations of one row, by column and disparity.
struct Volume {
  std::int32_t width;
  std::vector<std::int16_t> ncc = std::vector<std::int16_t>(static_cast<std::size_t>(width * disparities));

  std::int16_t& at(std::int32_t x, std::int32_t d) { return ncc[static_cast<std::size_t>(x * disparities + d)]; }
  [[nodiscard]] int cost(std::int32_t x, std::int32_t d) const {
    const int v = ncc[static_cast<std::size_t>(x * disparities + d)];
    if (v == 0) return occlusion_cost * max_ordered_cost / max_matching_cost * 3 / 4;
    return (ncc_one - std::max(v, 0)) / unit;
  }
};

Volume random_volume(std::int32_t width, std::uint64_t seed) {
  Volume volume{width};
  Rng rng(seed);
  for (std::int32_t x = 0; x < width; ++x) {
    for (std::int32_t d = 0; d <= std::min(x, disparities - 1); ++d) {
      volume.at(x, d) = static_cast<std::int16_t>(unit * (1 + static_cast<int>(rng.below(max_ordered_cost - 1))));
    }
  }
  return volume;
}

std::vector<RowWinner> solve(const std::vector<Volume>& rows, const SearchRow& search, const StereoParams& params) {
  static const auto workspace = std::make_unique<OrderedWorkspace>();
  const auto width = static_cast<std::size_t>(rows[0].width);
  std::vector<RowWinner> winners(width * rows.size());
  const std::int16_t* ncc[row_lanes] = {};
  RowWinner* out[row_lanes] = {};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    ncc[k] = rows[k].ncc.data();
    out[k] = winners.data() + k * width;
  }
  find_ordered_rows(search, disparities, params, ncc, static_cast<std::int32_t>(rows.size()), *workspace, out);
  return winners;
}

std::vector<RowWinner> solve(const Volume& row, const StereoParams& params) {
  return solve({row}, search_everything(row.width, disparities), params);
}

constexpr int far_away = 1 << 28;
enum : std::int32_t { any = -2, none = -1 };

/// Lowest cost of a row when column `fixed` is matched at disparity `d`, is matched with `none`, or `any` may be. One
/// step after the other over pairs (left pixels used, right pixels used), without any normalisation.
int lowest_cost(const Volume& v, std::int32_t fixed, std::int32_t d_fixed) {
  const int occlusion = occlusion_cost * max_ordered_cost / max_matching_cost;
  const auto index = [](std::int32_t d) { return static_cast<std::size_t>(d); };
  // By disparity of the last used pixels; more right pixels used is a smaller disparity.
  std::vector<int> now(index(disparities), 0);
  for (std::int32_t x = 0; x < v.width; ++x) {
    std::vector<int> next(index(disparities), far_away);
    for (std::int32_t d = 0; d < disparities; ++d) {
      const bool may_match = x != fixed || d_fixed == any || d_fixed == d;
      const bool may_occlude = x != fixed || d_fixed == any || d_fixed == none;
      if (may_match) next[index(d)] = now[index(d)] + v.cost(x, d);
      if (may_occlude && d > 0) next[index(d)] = std::min(next[index(d)], now[index(d - 1)] + occlusion);
    }
    for (std::int32_t d = disparities - 2; d >= 0; --d) {
      next[index(d)] = std::min(next[index(d)], next[index(d + 1)] + occlusion);
    }
    now = next;
  }
  return *std::min_element(now.begin(), now.end());
}

TEST(OrderedRows, ThePathIsTheCheapestOneAndUniqueWhereAnyOtherCostsMore) {
  StereoParams params;
  // 20 permille of a correlation of 1, for each column of a window.
  const int lead = 512 * 20 * 5 / 1000;
  int matched = 0, ambiguous = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Volume volume = random_volume(40, seed);
    const std::vector<RowWinner> winners = solve(volume, params);
    const int best = lowest_cost(volume, 0, any);
    for (std::int32_t x = 0; x < volume.width; ++x) {
      const RowWinner& winner = winners[static_cast<std::size_t>(x)];
      std::vector<int> costs;
      for (std::int32_t d = 0; d < disparities; ++d) costs.push_back(lowest_cost(volume, x, d));
      if (winner.cost == occluded_cost) {
        // Of two cheapest paths with other matches here one is taken, or none.
        EXPECT_TRUE(lowest_cost(volume, x, none) == best || std::count(costs.begin(), costs.end(), best) > 1)
            << seed << " " << x;
        EXPECT_FALSE(winner.unique);
        continue;
      }
      ++matched;
      EXPECT_EQ(costs[static_cast<std::size_t>(winner.index)], best) << seed << " " << x;
      int rival = far_away;
      for (std::int32_t d = 0; d < disparities; ++d) {
        if (std::abs(d - winner.index) > 1) rival = std::min(rival, costs[static_cast<std::size_t>(d)]);
      }
      EXPECT_EQ(winner.unique, rival >= best + lead) << seed << " " << x;
      ambiguous += winner.unique ? 0 : 1;
    }
  }
  EXPECT_GT(matched, 800);
  EXPECT_GT(ambiguous, 10);
}

TEST(OrderedRows, NoMatchBreaksTheOrderOrUsesAPixelTwice) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Volume volume = random_volume(96, seed);
    // Coarse costs have many paths of equal cost.
    if (seed % 2 == 0) {
      for (std::int16_t& v : volume.ncc) v = static_cast<std::int16_t>(v / 4096 * 4096);
    }
    SearchRow search;
    Rng rng(seed + 1000);
    for (std::int32_t x = 0; x < volume.width; x += 32) {
      search.runs[static_cast<std::size_t>(search.size++)] = {x, x + 32, 0, disparities};
    }
    std::int32_t last = -1000;
    const std::vector<RowWinner> winners = solve({volume}, search, {});
    for (std::int32_t x = 0; x < volume.width; ++x) {
      const RowWinner& winner = winners[static_cast<std::size_t>(x)];
      if (winner.cost == occluded_cost) continue;
      EXPECT_GT(x - winner.index, last) << seed << " " << x;
      last = x - winner.index;
    }
  }
}

TEST(OrderedRows, RunsThatSearchElsewhereKeepTheOrder) {
  constexpr std::int32_t width = 96, padded = 64;
  static const auto workspace = std::make_unique<OrderedWorkspace>();
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    std::vector<std::int16_t> ncc(static_cast<std::size_t>(width * padded));
    for (std::int16_t& v : ncc) v = static_cast<std::int16_t>(1 + rng.below(ncc_one - 1));
    SearchRow search;
    for (std::int32_t x = 0; x < width; x += 32) {
      search.runs[static_cast<std::size_t>(search.size++)] = {x, x + 32, 16 * static_cast<std::int32_t>(rng.below(4)),
                                                              16};
    }
    std::vector<RowWinner> winners(width);
    const std::int16_t* rows[] = {ncc.data()};
    RowWinner* out[] = {winners.data()};
    find_ordered_rows(search, padded, {}, rows, 1, *workspace, out);
    std::int32_t last = -1000;
    for (std::int32_t x = 0; x < width; ++x) {
      const RowWinner& winner = winners[static_cast<std::size_t>(x)];
      if (winner.cost == occluded_cost) continue;
      const SearchRun& run = search.runs[static_cast<std::size_t>(x / 32)];
      EXPECT_GE(winner.index, run.first);
      EXPECT_LT(winner.index, run.first + run.count);
      EXPECT_GT(x - winner.index, last) << seed << " " << x;
      last = x - winner.index;
    }
  }
}

TEST(OrderedRows, RowsSideBySideDoNotKnowEachOther) {
  std::vector<Volume> rows;
  for (std::uint64_t k = 0; k < 5; ++k) rows.push_back(random_volume(60, 70 + k));
  const SearchRow search = search_everything(60, disparities);
  const std::vector<RowWinner> together = solve(rows, search, {});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::vector<RowWinner> alone = solve(rows[k], {});
    for (std::size_t x = 0; x < 60; ++x) {
      EXPECT_EQ(together[k * 60 + x].index, alone[x].index);
      EXPECT_EQ(together[k * 60 + x].unique, alone[x].unique);
    }
  }
}

TEST(OrderedRows, TheMirroredAndSwappedRowHasTheSameMatches) {
  constexpr std::int32_t width = 400;
  // Chance matches, and ground that is nearer in the middle.
  Rng rng(11);
  const auto ground = [](std::int32_t x) { return x >= 150 && x < 260 ? 9 : 4; };
  Volume volume{width}, swapped{width};
  for (std::int32_t x = 0; x < width; ++x) {
    for (std::int32_t d = 0; d < disparities; ++d) {
      const std::uint32_t ncc = ground(x) == d ? ncc_one / 2 + rng.below(ncc_one / 2) : 1 + rng.below(ncc_one / 2);
      if (x - d < 0) continue;
      volume.at(x, d) = static_cast<std::int16_t>(ncc);
      swapped.at(width - 1 - (x - d), d) = static_cast<std::int16_t>(ncc);
    }
  }
  const std::vector<RowWinner> one = solve(volume, {});
  const std::vector<RowWinner> other = solve(swapped, {});
  // The ends of the images differ: there one of them sees more.
  int matched = 0;
  for (std::int32_t x = 40; x < width - 40; ++x) {
    const RowWinner& winner = one[static_cast<std::size_t>(x)];
    if (winner.cost == occluded_cost) continue;
    ++matched;
    const RowWinner& twin = other[static_cast<std::size_t>(width - 1 - (x - winner.index))];
    EXPECT_NE(twin.cost, occluded_cost) << x;
    EXPECT_EQ(twin.index, winner.index) << x;
  }
  EXPECT_GT(matched, 280);
}

TEST(SlopeSteps, TheForeshortenedPixelOfARisingSlopeIsMatchedAndAnOccludedOneIsNot) {
  constexpr std::int32_t width = 6;
  std::vector<std::int16_t> ncc(width * disparities, 1000);
  std::vector<RowWinner> winners(width, RowWinner{0, 3, true});
  winners[2] = {occluded_cost, 0, false};
  winners[3].index = winners[4].index = winners[5].index = 4;
  ncc[2 * disparities + 4] = 2000;
  match_slope_steps(width, disparities, ncc.data(), winners.data());
  EXPECT_EQ(winners[2].index, 4);
  EXPECT_TRUE(winners[2].unique);

  winners[2] = {occluded_cost, 0, false};
  winners[3].index = winners[4].index = winners[5].index = 5;
  match_slope_steps(width, disparities, ncc.data(), winners.data());
  EXPECT_EQ(winners[2].cost, occluded_cost);
  EXPECT_FALSE(winners[2].unique);
}

}  // namespace
}  // namespace ilp
