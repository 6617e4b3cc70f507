// Links against the ground that keyframes have in common, which is known by hand.

#include "sim/tools/score/link_score.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

using test::StripScene;

LinkScore score_of(const StripScene& scene, const std::vector<LinkedPair>& links) {
  TrueFrames truth(scene.truth, *scene.flight.camera);
  return score_links(scene.flight, links, truth);
}

TEST(LinkScore, LinksAreThoseOfTheRecords) {
  intake::Flight flight;
  LinkRecord link{.keyframe_id = 14, .place_id = 2};
  flight.links.push_back(link);
  const std::vector<LinkedPair> links = links_of(flight);
  ASSERT_EQ(links.size(), 1U);
  EXPECT_EQ(links[0].newer, 14);
  EXPECT_EQ(links[0].older, 2);
}

TEST(LinkScore, GroundThatWasOutOfViewBetweenIsSeenAgain) {
  // Images are 160 m wide: 30 % is common up to 112 m. The fifth keyframe is back over the first and the second.
  const StripScene scene({0, 60, 120, 180, 40});
  const LinkScore score = score_of(scene, {});
  // 180 to 40 m is farther than 112 m, so all that the fifth one shares with others it sees again.
  EXPECT_EQ(score.pairs, 3U);
  EXPECT_EQ(score.returned, 1U);
  EXPECT_EQ(score.linked_share(), 0);
  EXPECT_TRUE(std::isnan(score_of(StripScene({0, 60, 120, 180}), {}).linked_share())) << "nothing returns";
}

TEST(LinkScore, WhatTheChainKeepsInViewIsNoReturn) {
  EXPECT_EQ(score_of(StripScene({0, 40, 80, 60, 20}), {}).pairs, 0U);
  StripScene scene({0, 40, 80, 60, 20});
  for (const std::size_t k : {3U, 4U}) scene.keyframe(k).strip_id = 2;
  const LinkScore score = score_of(scene, {});
  EXPECT_EQ(score.pairs, 6U) << "but of another strip it is";
  EXPECT_EQ(score.returned, 2U);
}

TEST(LinkScore, CountsKeyframesAndPairsThatAreLinked) {
  const StripScene scene({0, 60, 120, 180, 240, 10, 130});
  // The sixth returns to the first two and the third (110 m), the seventh to all but the first two and the sixth.
  const LinkScore none = score_of(scene, {});
  ASSERT_EQ(none.returned, 2U);
  const LinkScore score = score_of(scene, {{6, 1}, {6, 2}});
  EXPECT_EQ(score.links, 2U);
  EXPECT_EQ(score.pairs_linked, 2U);
  EXPECT_EQ(score.linked, 1U);
  EXPECT_NEAR(score.linked_share(), 0.5, 1e-9);
  EXPECT_NEAR(score.pairs_linked_share(), 2.0 / static_cast<double>(none.pairs), 1e-9);
  EXPECT_EQ(score.false_links, 0U);
}

TEST(LinkScore, LinkIsFalseOnlyIfNothingIsInCommon) {
  const StripScene scene({0, 60, 120, 180, 240});
  // 60 m apart, 120 m apart (a quarter in common), 180 m apart.
  const LinkScore score = score_of(scene, {{2, 1}, {3, 1}, {4, 1}, {9, 1}});
  EXPECT_EQ(score.links, 3U) << "the truth does not know keyframe 9";
  EXPECT_EQ(score.false_links, 1U);
  EXPECT_EQ(score.linked, 0U) << "a link within the chain is no return";
}

}  // namespace
}  // namespace ilp::score
