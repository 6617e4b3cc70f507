// Precision, recall, completeness and double coding of masks that are wrong in known ways.

#include "sim/tools/score/mask_score.hpp"

#include <gtest/gtest.h>

#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

using test::StripScene;

std::map<std::int64_t, MaskScore> scores_of(const StripScene& scene) {
  TrueFrames truth(scene.truth, *scene.flight.camera);
  return score_masks(scene.flight, truth);
}

void fill_columns(host::Raster<std::uint8_t>& mask, int begin, int end, std::uint8_t value) {
  for (int row = 0; row < mask.height; ++row) {
    for (int column = begin; column < end; ++column) mask.at(column, row) = value;
  }
}

TEST(MaskScore, CountsWhatIsTooMuchAndWhatIsMissing) {
  StripScene scene;
  // The third keyframe newly sees columns 130 to 159 (the ground from 110 to 140): claim 120 to 149 instead.
  ASSERT_TRUE(scene.newly_seen(2, 130) && scene.newly_seen(2, 159));
  ASSERT_FALSE(scene.newly_seen(2, 129));
  fill_columns(scene.keyframe(2).mask, 0, 160, 0);
  fill_columns(scene.keyframe(2).mask, 120, 150, 255);
  const auto scores = scores_of(scene);
  const MaskScore& third = scores.at(3);
  EXPECT_EQ(third.masked, 30U * 120U);
  EXPECT_EQ(third.newly_seen, 30U * 120U);
  EXPECT_NEAR(third.precision(), 20.0 / 30, 1e-9);
  EXPECT_NEAR(third.recall(), 20.0 / 30, 1e-9);
  // Its first ten columns are the last ones that the second keyframe claims.
  EXPECT_EQ(third.double_coded, 10U * 120U);
  EXPECT_EQ(scores.at(2).double_coded, 0U);
  MaskScore sum;
  for (const auto& [id, score] : scores) sum.add(score);
  EXPECT_EQ(sum.masked, (130U + 4 * 30U) * 120U);
  EXPECT_NEAR(sum.double_coded_share(), 10.0 / 250, 1e-9);
}

TEST(MaskScore, GroundThatReturnsIntoViewIsNotNew) {
  // The third keyframe stands behind the first; the fourth comes back to where all has been seen.
  StripScene scene({0, 40, -30, 10});
  const auto scores = scores_of(scene);
  for (const auto& [id, score] : scores) {
    EXPECT_EQ(score.masked, score.both) << id;
    EXPECT_EQ(score.newly_seen, score.both) << id;
    EXPECT_EQ(score.double_coded, 0U) << id;
  }
  // What the forgetful would claim there has been coded before.
  fill_columns(scene.keyframe(3).mask, 0, 160, 255);
  const MaskScore last = scores_of(scene).at(4);
  EXPECT_EQ(last.masked, 160U * 120U);
  std::size_t known = 0;
  for (int column = 0; column < 160; ++column) {
    bool claimed = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = scene.ground_x(3, column) - scene.x[k] + 79.5;
      claimed = claimed || (at >= 0 && at < 160 && scene.newly_seen(k, static_cast<int>(at)));
    }
    known += claimed ? 120U : 0U;
  }
  EXPECT_GT(known, 100U * 120U);
  EXPECT_EQ(last.double_coded, known);
}

/// Keyframes from the one with this place on are a strip of their own.
void break_strip(StripScene& scene, std::size_t first) {
  intake::Strip& strip = scene.flight.strips[1];
  for (std::size_t k = first; k < scene.x.size(); ++k) {
    const auto id = static_cast<std::int64_t>(k) + 1;
    std::erase(strip.keyframes, id);
    scene.flight.strips[2].keyframes.push_back(id);
    scene.keyframe(k).strip_id = 2;
  }
  scene.flight.strips[2].id = 2;
  intake::Keyframe& last = scene.keyframe(first - 1);
  last.depth->verdict = DepthVerdict::no_partner;
  last.depth->partner_id = 0;
}

void send(intake::Keyframe& keyframe, std::size_t image_bytes, std::size_t depth_bytes) {
  intake::ProductAccount account{.bytes = image_bytes};
  keyframe.products[static_cast<std::size_t>(ProductKind::image)] = account;
  account.bytes = depth_bytes;
  keyframe.products[static_cast<std::size_t>(ProductKind::depth)] = account;
}

TEST(MaskScore, GroundThatAnotherStripHasSeenIsNotNew) {
  // The second strip begins 60 m back: images are 160 m wide, so it knows all but 30 m of what its first pair sees.
  StripScene scene({0, 40, 80, 60, 110});
  break_strip(scene, 3);
  fill_columns(scene.keyframe(3).mask, 0, 160, 255);
  send(scene.keyframe(3), 600, 200);
  const MaskScore fourth = scores_of(scene).at(4);
  // It sees -20 to 140. The pair before saw -40 to 80 and that of the second keyframe up to 120: 20 columns are new.
  // Its partner sees them from 30 on.
  EXPECT_EQ(fourth.masked, 160U * 120U);
  EXPECT_NEAR(fourth.precision(), 20.0 / 160, 1e-9);
  EXPECT_EQ(fourth.bytes, 800U);
  EXPECT_NEAR(fourth.bytes_again_share(), 140.0 / 160, 1e-9);
}

TEST(MaskScore, BytesOfAKeyframeWithoutAPoseOrAMaskCountForItsWholeImage) {
  StripScene scene({0, 40, 80, 60, 110});
  break_strip(scene, 3);
  for (const bool posed : {false, true}) {
    intake::Keyframe& keyframe = scene.keyframe(3);
    if (posed) {
      fill_columns(keyframe.mask, 0, 160, 0);  // a thumbnail comes down beside an empty mask
    } else {
      keyframe.pose.reset();
      keyframe.mask = {};
    }
    send(keyframe, 1000, 0);
    const MaskScore score = scores_of(scene).at(4);
    EXPECT_EQ(score.masked, 0U);
    EXPECT_NEAR(score.bytes_again, 1000 * 140.0 / 160, 1e-6);
    scene = StripScene({0, 40, 80, 60, 110});
    break_strip(scene, 3);
  }
}

TEST(MaskScore, GroundIsNewAgainToAViewThatIsMuchFiner) {
  for (const auto& [height, fresh] : {std::pair{70.0, false}, std::pair{50.0, true}}) {
    StripScene scene({0, 40, 20, 25});
    break_strip(scene, 2);
    for (const std::size_t k : {2U, 3U}) {
      scene.truth.poses[StripScene::name_of(k)].centre.z() = height;
      scene.truth.depths[StripScene::name_of(k)] = host::Raster<float>(160, 120, static_cast<float>(height));
    }
    fill_columns(scene.keyframe(2).mask, 40, 120, 255);
    fill_columns(scene.keyframe(2).mask, 0, 40, 0);
    fill_columns(scene.keyframe(2).mask, 120, 160, 0);
    EXPECT_EQ(scores_of(scene).at(3).precision(), fresh ? 1 : 0) << height;
  }
}

TEST(MaskScore, CompletenessIsTheShareOfTheDueGroundWithDepth) {
  StripScene scene;
  for (int row = 0; row < 30; ++row) {  // a quarter of the second keyframe's depth is lost
    for (int column = 0; column < 160; ++column) scene.keyframe(1).inverse_depth.at(column, row) = 0;
  }
  const auto scores = scores_of(scene);
  EXPECT_NEAR(scores.at(1).completeness(), 1, 1e-9);
  EXPECT_NEAR(scores.at(2).completeness(), 0.75, 1e-9);
  EXPECT_EQ(scores.at(5).expected, 0U);  // no partner to match it with
  EXPECT_TRUE(std::isnan(scores.at(5).completeness()));
  // A pair that gave nothing is missing altogether; its mask shows what no pair has reconstructed.
  intake::Keyframe& third = scene.keyframe(2);
  third.depth->verdict = DepthVerdict::too_few_valid;
  third.depth->partner_id = 0;
  third.inverse_depth = {};
  fill_columns(third.mask, 0, 160, 0);
  fill_columns(third.mask, 130, 160, 255);
  const MaskScore failed = scores_of(scene).at(3);
  EXPECT_EQ(failed.expected, 30U * 120U);
  EXPECT_EQ(failed.with_depth, 0U);
  EXPECT_EQ(failed.precision(), 1);
  EXPECT_EQ(failed.recall(), 1);
}

}  // namespace
}  // namespace ilp::score
