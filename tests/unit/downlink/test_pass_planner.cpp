#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/downlink/pass_planner.hpp"

namespace ilp {
namespace {

using Candidates = std::vector<PlanCandidate>;

std::uint32_t whole(double value) {
  return static_cast<std::uint32_t>(value);
}

/// Layers as a codec makes them: sizes grow by about two, gains fall; now and then a layer that gains more than the one
/// before it, and products of which some layers are down.
PlanCandidate random_candidate(std::int64_t id, double largest, Rng& rng) {
  PlanCandidate candidate{.id = id, .layers = static_cast<std::uint8_t>(1 + rng.below(4))};
  candidate.sent = static_cast<std::uint8_t>(rng.uniform() < 0.3 ? rng.below(candidate.layers) : 0);
  const double place = 0.05 + rng.uniform();
  double bytes = 1, utility = 0;
  double step = largest * (0.05 + rng.uniform()) / (1U << candidate.layers), gain = place;
  for (std::size_t k = 0; k < candidate.layers; ++k) {
    if (k >= candidate.sent) bytes += step;
    utility += gain;
    candidate.bytes[k] = k >= candidate.sent ? whole(bytes) : 0;
    candidate.utility[k] = utility;
    step *= 1.5 + rng.uniform();
    gain *= 0.2 + rng.uniform();
  }
  return candidate;
}

Candidates random_case(std::size_t count, double largest, Rng& rng) {
  Candidates candidates;
  for (std::size_t i = 0; i < count; ++i) {
    candidates.push_back(random_candidate(static_cast<std::int64_t>(i + 1), largest, rng));
  }
  return candidates;
}

double down(const PlanCandidate& c) {
  return c.sent == 0 ? 0.0 : c.utility[c.sent - 1U];
}

std::uint64_t all_bytes(const Candidates& candidates) {
  std::uint64_t sum = 0;
  for (const PlanCandidate& c : candidates) sum += c.bytes[c.layers - 1U];
  return sum;
}

/// The knapsack with layer precedence, exactly: best gain for every number of bytes.
double optimum(const Candidates& candidates, std::size_t bytes) {
  std::vector<double> best(bytes + 1, 0.0);
  for (const PlanCandidate& c : candidates) {
    std::vector<double> with = best;
    for (std::size_t k = c.sent; k < c.layers; ++k) {
      const double gain = c.utility[k] - down(c);
      for (std::size_t b = c.bytes[k]; b <= bytes; ++b) with[b] = std::max(with[b], best[b - c.bytes[k]] + gain);
    }
    best = std::move(with);
  }
  return best[bytes];
}

class PassPlannerTest : public testing::Test {
 protected:
  PassPlan plan(const Candidates& candidates, std::uint64_t bytes) {
    PassPlan result;
    plan_pass(candidates, bytes, *workspace, result);
    return result;
  }
  /// A plan must be one that can be flown, whatever it is worth.
  void expect_possible(const Candidates& candidates, std::uint64_t bytes, const PassPlan& result) {
    std::uint64_t sum = 0;
    double gain = 0;
    std::vector<std::int64_t> seen;
    for (const PlannedFile& file : result.files) {
      const PlanCandidate& c = candidates[static_cast<std::size_t>(file.id - 1)];
      EXPECT_EQ(file.first_layer, c.sent + 1) << "layers stand on those before them";
      ASSERT_LE(file.first_layer, file.last_layer);
      ASSERT_LE(file.last_layer, c.layers);
      EXPECT_EQ(file.bytes, c.bytes[file.last_layer - 1U]);
      sum += file.bytes;
      gain += c.utility[file.last_layer - 1U] - down(c);
      seen.push_back(file.id);
    }
    std::sort(seen.begin(), seen.end());
    EXPECT_EQ(std::adjacent_find(seen.begin(), seen.end()), seen.end()) << "one file for each product";
    EXPECT_LE(sum, bytes);
    EXPECT_EQ(sum, result.bytes);
    EXPECT_NEAR(gain, result.gain, 1e-9 * (1 + gain));
  }

  std::unique_ptr<PlanWorkspace> workspace = std::make_unique<PlanWorkspace>();
};

struct Regret {
  double mean = 0, p99 = 0, worst = 0;
};

Regret summary(std::vector<double> regrets) {
  std::sort(regrets.begin(), regrets.end());
  Regret result;
  for (const double r : regrets) result.mean += r / static_cast<double>(regrets.size());
  result.p99 = regrets[regrets.size() * 99 / 100];
  result.worst = regrets.back();
  return result;
}

TEST_F(PassPlannerTest, LosesLittleAgainstTheExactKnapsack) {
  struct Size {
    std::size_t products;
    double largest;
    int cases;
  };
  // Few products with large files are the hard cases: the end of a pass is a large part of it. Above 64 products plans
  // go by value per byte alone.
  for (const Size& size : {Size{3, 4000, 400}, Size{6, 3000, 400}, Size{12, 1500, 300}, Size{40, 400, 100},
                           Size{150, 150, 20}, Size{256, 80, 20}}) {
    Rng rng(7, size.products);
    std::vector<double> regrets;
    while (static_cast<int>(regrets.size()) < size.cases) {
      const Candidates candidates = random_case(size.products, size.largest, rng);
      const auto bytes =
          static_cast<std::uint64_t>((0.05 + 0.9 * rng.uniform()) * static_cast<double>(all_bytes(candidates)));
      const PassPlan result = plan(candidates, bytes);
      expect_possible(candidates, bytes, result);
      const double best = optimum(candidates, bytes);
      if (best <= 0) continue;
      regrets.push_back(1 - result.gain / best);
      EXPECT_GE(regrets.back(), -1e-9) << "the reference is the optimum";
    }
    const Regret regret = summary(regrets);
    std::printf("%3zu products: regret mean %.4f %%, 99th percentile %.4f %%, worst %.4f %%\n", size.products,
                100 * regret.mean, 100 * regret.p99, 100 * regret.worst);
    EXPECT_LT(regret.mean, 0.002) << size.products;
    EXPECT_LT(regret.worst, 0.05) << size.products;
  }
}

TEST_F(PassPlannerTest, WhatFitsGoesWhole) {
  Rng rng(3, 1);
  const Candidates candidates = random_case(256, 5000, rng);
  const PassPlan result = plan(candidates, all_bytes(candidates));
  expect_possible(candidates, all_bytes(candidates), result);
  ASSERT_EQ(result.files.size(), candidates.size());
  for (const PlannedFile& file : result.files) {
    EXPECT_EQ(file.last_layer, candidates[static_cast<std::size_t>(file.id - 1)].layers);
  }
}

TEST_F(PassPlannerTest, RequestsGoFirstThenNewProductsThenRefinements) {
  Rng rng(5, 1);
  Candidates candidates = random_case(60, 5000, rng);
  for (const std::size_t i : {11U, 30U}) candidates[i].requested = true;
  const PassPlan result = plan(candidates, all_bytes(candidates) * 3 / 4);
  int stage = 0;
  double before = 0;
  for (const PlannedFile& file : result.files) {
    const bool requested = candidates[static_cast<std::size_t>(file.id - 1)].requested;
    const int own = requested ? 0 : file.first_layer == 1 ? 1 : 2;
    EXPECT_GE(own, stage);
    if (own == stage && own > 0) {
      EXPECT_LE(file.gain / file.bytes, before * (1 + 1e-9)) << "most for its bytes first";
    }
    before = file.gain / file.bytes;
    stage = own;
  }
  EXPECT_EQ(stage, 2);
}

TEST_F(PassPlannerTest, NothingFitsIntoNothing) {
  Rng rng(5, 2);
  const Candidates candidates = random_case(20, 5000, rng);
  EXPECT_TRUE(plan(candidates, 0).files.empty());
  EXPECT_TRUE(plan({}, 1000).files.empty());
}

TEST_F(PassPlannerTest, OfMoreThanItCanHoldTheListKeepsTheMostPromising) {
  Rng rng(9, 1);
  Candidates candidates = random_case(3 * limits::max_plan_candidates, 5000, rng);
  CandidateList list;
  for (const PlanCandidate& c : candidates) list.offer(c);
  ASSERT_EQ(list.all().size(), limits::max_plan_candidates);
  std::vector<double> all;
  for (const PlanCandidate& c : candidates) all.push_back(best_efficiency(c));
  std::sort(all.rbegin(), all.rend());
  for (const PlanCandidate& c : list.all()) EXPECT_GE(best_efficiency(c), all[limits::max_plan_candidates - 1]);
}

TEST(UtilityOfLayersTest, GrowsWithQualityPlaceAndIndex) {
  ProductRecord image;
  image.kind = ProductKind::image;
  image.layers = 3;
  image.layer_quality[0] = 22;
  image.layer_quality[1] = 30;
  image.layer_quality[2] = std::numeric_limits<float>::infinity();
  const ProductUtility dull{0.1, 0.2, 60000, false}, rich{0.8, 0.2, 60000, false}, asked{0.1, 0.2, 60000, true};
  EXPECT_EQ(utility_of_layers(image, dull, 0), 0);
  EXPECT_LT(utility_of_layers(image, dull, 1), utility_of_layers(image, dull, 2));
  EXPECT_LT(utility_of_layers(image, dull, 2), utility_of_layers(image, dull, 3));
  EXPECT_LT(utility_of_layers(image, dull, 3), utility_of_layers(image, rich, 3));
  EXPECT_GT(utility_of_layers(image, asked, 1), utility_of_layers(image, rich, 3)) << "the ground's wish goes before";
  // 15 of 21 dB: (0.2 + 0.02) * (0.1 + 0.2) * 15 / 21.
  EXPECT_NEAR(utility_of_layers(image, dull, 2), 0.066 * 15 / 21, 1e-9);
  ProductRecord depth;
  depth.kind = ProductKind::depth;
  depth.layers = 2;
  depth.layer_quality[0] = 4;
  depth.layer_quality[1] = 0.5F;
  EXPECT_LT(utility_of_layers(depth, dull, 1), utility_of_layers(depth, dull, 2));
}

}  // namespace
}  // namespace ilp
