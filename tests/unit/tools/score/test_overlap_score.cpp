// Achieved and measured overlaps of a flight whose footprints are rectangles.

#include "sim/tools/score/overlap_score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

using test::StripScene;

OverlapScore score_of(const StripScene& scene, double target) {
  TrueFrames truth(scene.truth, *scene.flight.camera);
  return score_overlaps(scene.flight, target, truth);
}

void measure(StripScene& scene, std::int64_t frame, std::int64_t keyframe, double overlap,
             OverlapVerdict verdict = OverlapVerdict::ok) {
  OverlapRecord record{.id = frame, .keyframe_id = keyframe, .verdict = verdict, .overlap = overlap};
  scene.flight.overlaps[frame] = record;
}

TEST(OverlapScore, AchievedOverlapIsTrueOfKeyframesInARow) {
  // Steps of 32, 16 and 48 px: overlaps of 0.8, 0.9 and 0.7.
  const OverlapScore score = score_of(StripScene({0, 32, 48, 96}), 0.82);
  EXPECT_EQ(score.target, 0.82);
  ASSERT_EQ(score.achieved.size(), 3U);
  EXPECT_NEAR(score.achieved[1].true_overlap, 0.9, 1e-4);
  EXPECT_NEAR(score.true_mean, 0.8, 1e-4);
  EXPECT_NEAR(score.true_std, 0.1, 1e-4);
}

TEST(OverlapScore, KeyframesThatDoNotFollowEachOtherSayNothing) {
  StripScene scene;
  scene.flight.strips.at(1).keyframes = {1, 2, 4, 5};  // nothing came down of the third
  EXPECT_EQ(score_of(scene, 0.8).achieved.size(), 2U);
}

TEST(OverlapScore, ErrorsOfMeasurementAreThoseAgainstTheFootprints) {
  StripScene scene({0, 32, 48, 96});
  measure(scene, 2, 1, 0.81);
  measure(scene, 3, 2, 0.92);
  measure(scene, 4, 3, 0.69);
  measure(scene, 1, 1, 1.0);  // the first of the strip
  OverlapScore score = score_of(scene, 0.8);
  ASSERT_EQ(score.measured.size(), 3U);
  EXPECT_NEAR(score.error_bias, 0.01, 1e-4);
  EXPECT_NEAR(score.error_median, 0.01, 1e-4);
  EXPECT_NEAR(score.error_p95, 0.02, 1e-4);
  // A frame between keyframes, known from the onboard database.
  FrameRecord frame{.id = 77};
  std::snprintf(frame.name, sizeof(frame.name), "0099.pgm");
  scene.flight.frames[77] = frame;
  scene.truth.poses["0099.pgm"] = {scene.truth.poses.at("0001.pgm").cam_from_world, Vec3(8, 0, 100)};
  scene.truth.depths["0099.pgm"] = scene.truth.depths.at("0001.pgm");
  measure(scene, 77, 1, 0.5);
  score = score_of(scene, 0.8);
  ASSERT_EQ(score.measured.size(), 4U);
  EXPECT_NEAR(score.measured.back().true_footprint, 0.95, 1e-4);
  EXPECT_NEAR(score.error_p95, 0.45, 1e-4);
  // An answer that is no number does not count as a wrong one.
  measure(scene, 77, 1, 0.0, OverlapVerdict::overlap_unknown);
  EXPECT_EQ(score_of(scene, 0.8).measured.size(), 3U);
}

}  // namespace
}  // namespace ilp::score
