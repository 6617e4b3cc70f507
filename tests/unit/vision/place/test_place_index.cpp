#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/place/place_index.hpp"

namespace ilp {
namespace {

constexpr std::size_t first = limits::place_vocabulary_places;

/// Features with random descriptors: no two places have anything in common.
PlaceFeatures place(std::uint64_t number) {
  Rng rng(number, 17);
  PlaceFeatures features;
  for (std::size_t k = 0; k < limits::max_place_features; ++k) {
    PlaceFeature feature{.level = static_cast<std::uint8_t>(1 + rng.below(3)),
                         .angle = static_cast<std::uint8_t>(rng.below(256))};
    for (std::uint32_t& word : feature.descriptor) word = rng.next();
    (void)features.push_back(feature);
  }
  return features;
}

/// The same place seen again: turned, a level larger, a tenth of the bits different, half of the features others.
PlaceFeatures seen_again(std::uint64_t number, std::uint8_t turn) {
  PlaceFeatures features = place(number);
  const PlaceFeatures others = place(number + 1'000'000);
  Rng rng(number, 18);
  for (std::size_t k = 0; k < features.size(); ++k) {
    PlaceFeature& feature = features[k];
    if (k % 2 == 1) feature = others[k];
    feature.angle = static_cast<std::uint8_t>(feature.angle + turn);
    ++feature.level;
    for (int bit = 0; bit < 26; ++bit) feature.descriptor[rng.below(8)] ^= 1U << rng.below(32);
  }
  return features;
}

std::span<const PlaceFeature> all(const PlaceFeatures& features) {
  return {features.data(), features.size()};
}

struct Places {
  std::unique_ptr<PlaceIndex> index = std::make_unique<PlaceIndex>();
  std::unique_ptr<PlaceQueryWorkspace> workspace = std::make_unique<PlaceQueryWorkspace>();

  Places() { index->clear(); }
  void insert(std::size_t slot, std::uint64_t number) {
    ASSERT_TRUE(index->insert(slot, static_cast<std::int64_t>(number), all(place(number))).ok()) << slot;
  }
  void insert_up_to(std::size_t count) {
    for (std::size_t slot = index->size(); slot < count; ++slot) insert(slot, slot + 100);
  }
  PlaceCandidates query(const PlaceFeatures& features, std::int64_t excluding = 1'000'000) {
    PlaceCandidates best;
    EXPECT_TRUE(index->query(all(features), excluding, *workspace, best).ok());
    return best;
  }
  [[nodiscard]] bool same_bytes(const Places& other) const {
    return std::memcmp(static_cast<const void*>(index.get()), static_cast<const void*>(other.index.get()),
                       sizeof(PlaceIndex)) == 0;
  }
};

TEST(PlaceIndex, FindsAPlaceSeenAgainAtAnyHeadingAndAnotherScale) {
  Places places;
  places.insert_up_to(600);
  for (const std::uint64_t number : {100U, 131U, 132U, 400U, 699U}) {
    for (const int turn : {0, 31, 64, 200}) {
      const PlaceCandidates best = places.query(seen_again(number, static_cast<std::uint8_t>(turn)));
      ASSERT_FALSE(best.empty());
      EXPECT_EQ(best[0].keyframe_id, static_cast<std::int64_t>(number)) << turn;
      EXPECT_EQ(best[0].slot, number - 100);
      if (best.size() > 1) {
        EXPECT_GT(best[0].votes, 2 * best[1].votes);
      }
      EXPECT_TRUE(std::is_sorted(best.begin(), best.end(),
                                 [](const PlaceCandidate& a, const PlaceCandidate& b) { return a.votes > b.votes; }));
    }
  }
}

TEST(PlaceIndex, VotesThatDoNotAgreeInAngleCountLittle) {
  Places places;
  places.insert_up_to(200);
  PlaceFeatures scrambled = seen_again(150, 0);
  const int agreed = places.query(scrambled)[0].votes;
  Rng rng(4);
  for (PlaceFeature& feature : scrambled) feature.angle = static_cast<std::uint8_t>(rng.below(256));
  const PlaceCandidates best = places.query(scrambled);
  EXPECT_LT(best.empty() ? 0 : best[0].votes, agreed / 3);
}

TEST(PlaceIndex, BeforeTheVocabularyIsCompleteItComparesWithAll) {
  Places places;
  places.insert_up_to(5);
  EXPECT_FALSE(places.index->has_vocabulary());
  for (std::uint64_t number = 100; number < 105; ++number) {
    ASSERT_FALSE(places.query(seen_again(number, 70)).empty());
    EXPECT_EQ(places.query(seen_again(number, 70))[0].keyframe_id, static_cast<std::int64_t>(number));
  }
  EXPECT_TRUE(places.query(place(7)).empty() || places.query(place(7))[0].votes < 1000);
}

TEST(PlaceIndex, ARestartGivesTheSameBytesAndAnswers) {
  Places flown, restarted;
  flown.insert_up_to(300);
  Rng rng(9);
  std::vector<std::uint64_t> number_in(300);
  for (std::size_t slot = 0; slot < 300; ++slot) number_in[slot] = slot + 100;
  // A full memory: what was there goes and something else comes.
  for (std::uint64_t next = 400; next < 700; ++next) {
    const std::size_t slot = first + rng.below(300 - first);
    ASSERT_TRUE(flown.index->remove(slot).ok());
    flown.insert(slot, next);
    number_in[slot] = next;
  }
  for (std::size_t slot = 0; slot < 300; ++slot) restarted.insert(slot, number_in[slot]);
  EXPECT_TRUE(flown.same_bytes(restarted));

  // In any other order as well, the first ones among themselves and the others behind them.
  Places backwards;
  for (std::size_t slot = first; slot-- > 0;) backwards.insert(slot, number_in[slot]);
  for (std::size_t slot = 300; slot-- > first;) backwards.insert(slot, number_in[slot]);
  EXPECT_TRUE(flown.same_bytes(backwards));
  for (const std::size_t slot : {40U, 200U}) {
    const PlaceCandidates a = flown.query(seen_again(number_in[slot], 12));
    const PlaceCandidates b = backwards.query(seen_again(number_in[slot], 12));
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].slot, b[k].slot);
    EXPECT_EQ(a[0].slot, slot);
  }
  flown.index->clear();
  EXPECT_TRUE(flown.same_bytes(Places()));
}

TEST(PlaceIndex, WhatWasRemovedOrExcludedIsNotFound) {
  Places places;
  places.insert_up_to(100);
  ASSERT_TRUE(places.index->remove(60).ok());
  for (const PlaceCandidate& c : places.query(seen_again(160, 0))) EXPECT_NE(c.keyframe_id, 160);
  for (const PlaceCandidate& c : places.query(seen_again(170, 0), 170)) EXPECT_LT(c.keyframe_id, 170);
  EXPECT_EQ(places.query(seen_again(170, 0), 171)[0].keyframe_id, 170);
  EXPECT_EQ(places.index->size(), 99U);
  EXPECT_FALSE(places.index->holds(60));
  EXPECT_EQ(places.query(seen_again(161, 0), 162)[0].keyframe_id, 161);
}

TEST(PlaceIndex, AFirstPlaceWhoseFeaturesWereLostLeavesTheOthersUsable) {
  Places places;
  for (std::size_t slot = 0; slot < 100; ++slot) {
    if (slot == 3) {
      ASSERT_TRUE(places.index->insert(slot, 103, {}).ok());
    } else {
      places.insert(slot, slot + 100);
    }
  }
  EXPECT_TRUE(places.index->has_vocabulary());
  EXPECT_EQ(places.query(seen_again(104, 9))[0].keyframe_id, 104);
  EXPECT_EQ(places.query(seen_again(199, 9))[0].keyframe_id, 199);
}

TEST(PlaceIndex, FlippedBitsAreNoticedOrCostAnAnswerAndNothingElse) {
  Places places;
  places.insert_up_to(80);
  const auto whole = std::make_unique<PlaceIndex>(*places.index);
  auto* const bytes = reinterpret_cast<std::uint8_t*>(places.index.get());
  const PlaceFeatures seen = seen_again(150, 40);
  Rng rng(77);
  int noticed = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::memcpy(static_cast<void*>(places.index.get()), static_cast<const void*>(whole.get()), sizeof(PlaceIndex));
    // Half of them where the lists are kept, which are a small part of the memory.
    const std::size_t lists = sizeof(PlaceIndex) * 9 / 10;
    for (int flips = 0; flips < 20; ++flips) {
      const std::size_t at = flips % 2 == 0 ? rng.below(static_cast<std::uint32_t>(sizeof(PlaceIndex)))
                                            : lists + rng.below(static_cast<std::uint32_t>(sizeof(PlaceIndex) - lists));
      bytes[at] ^= static_cast<std::uint8_t>(1U << rng.below(8));
    }
    PlaceCandidates best;
    const Status asked = places.index->query(all(seen), 1000, *places.workspace, best);
    for (const PlaceCandidate& candidate : best) EXPECT_LT(candidate.slot, limits::max_places);
    const Status removed = places.index->remove(first + rng.below(static_cast<std::uint32_t>(80 - first)));
    const Status inserted = places.index->insert(90, 190, all(place(190)));
    noticed += asked.ok() && removed.ok() && inserted.ok() ? 0 : 1;
  }
  EXPECT_GT(noticed, 0);
}

TEST(PlaceIndex, RefusesWhatWouldMakeItsBytesDependOnHistory) {
  Places places;
  const PlaceFeatures features = place(1);
  EXPECT_TRUE(places.index->insert(limits::max_places, 1, all(features)).is(StatusCode::invalid_argument));
  EXPECT_TRUE(places.index->insert(first, 1, all(features)).is(StatusCode::not_ready));
  places.insert(0, 100);
  EXPECT_TRUE(places.index->insert(0, 1, all(features)).is(StatusCode::invalid_argument));
  EXPECT_TRUE(places.index->remove(0).is(StatusCode::invalid_argument));
  EXPECT_TRUE(places.index->remove(first).is(StatusCode::not_found));
  EXPECT_TRUE(places.index->remove(limits::max_places).is(StatusCode::invalid_argument));
}

}  // namespace
}  // namespace ilp
