// What the wide search decides where the coarse search says `unknown`, on the mixture of pairs: how many rightly, and
// that none is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>

#include "fsw/vision/twoview/feature_overlap.hpp"
#include "tests/unit/vision/overlap/mixed_pairs.hpp"
#include "tests/unit/vision/overlap/search_widely.hpp"

namespace ilp {
namespace {

OverlapResult measure(const test::Image& a, const test::Image& b, const OverlapParams& params) {
  static const auto workspace = std::make_unique<OverlapWorkspace>();
  OverlapResult result;
  EXPECT_TRUE(measure_overlap(a.view(), b.view(), params, *workspace, result).ok());
  return result;
}

TEST(WideSearchOfRandomPairs, DecidesUnknownPairsAndNoneWrongly) {
  struct Count {
    int unknown = 0, right = 0, wrong = 0;
  };
  std::map<std::string, Count> counts;
  for (int i = 0; i < ILP_WIDE_PAIRS; ++i) {
    const bool full_turn = i % 2 == 0;
    const test::MixedPair pair = test::mixed_pair(i, full_turn);
    const OverlapParams params = full_turn ? test::any_attitude() : OverlapParams{};
    if (measure(pair.a, pair.b, params).verdict != OverlapVerdict::overlap_unknown) continue;
    Count& count = counts[pair.kind];
    ++count.unknown;
    const OverlapResult found = test::search_widely(pair.a.view(), pair.b.view(), params.min_overlap);
    if (found.verdict != OverlapVerdict::ok) continue;
    const bool right = std::fabs(found.overlap - pair.truth) <= 0.05;
    ++(right ? count.right : count.wrong);
    EXPECT_TRUE(right) << "pair " << i << ", " << pair.kind << ": " << found.overlap << " instead of " << pair.truth;
  }
  for (const auto& [kind, count] : counts) {
    std::printf("%-24s %4d unknown, %4d decided rightly, %d wrongly\n", kind.c_str(), count.unknown, count.right,
                count.wrong);
  }
}

}  // namespace
}  // namespace ilp
