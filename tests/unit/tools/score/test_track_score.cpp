// Scores of the ground below the track, over level ground where everything is known by hand.
#include <gtest/gtest.h>

#include "sim/tools/score/track_score.hpp"
#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

TrackScore score_of(const test::StripScene& scene) {
  TrueFrames truth(scene.truth, *scene.flight.camera);
  AlignedStrip strip{.id = 1};
  strip.true_from_strip.scale = scene.unit;
  return score_track(scene.flight, {{1, strip}}, truth);
}

TEST(TrackScore, OfAPerfectStripIsPerfect) {
  const TrackScore score = score_of(test::StripScene());
  EXPECT_EQ(score.points, 5U * 12 * 9);
  EXPECT_EQ(score.mapped_share(), 1);
  EXPECT_LT(score.error_median_percent, 1e-4);
  EXPECT_NEAR(score.landing_ratio, 1, 1e-9);
}

TEST(TrackScore, CountsGroundWithoutDepthAndStatesTheErrorOfTheDistance) {
  test::StripScene scene;
  scene.distort([](std::size_t, int, int) { return 1.02; });
  EXPECT_NEAR(score_of(scene).error_median_percent, 2, 1e-3);
  // Nothing of the first keyframe came down: it alone has the ground from -40 to 10 m.
  scene.keyframe(0).inverse_depth = {};
  const auto all = static_cast<double>(score_of(test::StripScene()).points);
  EXPECT_LT(score_of(scene).mapped_share(), 1 - 0.5 * 108 / all);
}

TEST(TrackScore, TheFinestKeyframeThatHasTheGroundCountsWhereTheFlightEnds) {
  test::StripScene scene;
  // The last keyframe is at half the height, and its own depths did not come down.
  const std::string name = test::StripScene::name_of(4);
  scene.truth.poses[name].centre.z() = 50;
  scene.truth.depths[name] = host::Raster<float>(test::StripScene::width, test::StripScene::height, 50);
  EXPECT_NEAR(score_of(scene).landing_ratio, 2, 0.01);
  scene.keyframe(4).inverse_depth =
      host::Raster<float>(test::StripScene::width, test::StripScene::height, static_cast<float>(scene.unit / 50));
  EXPECT_NEAR(score_of(scene).landing_ratio, 1, 0.01);
}

TEST(TrackScore, WithoutAnyStripThereIsNone) {
  const test::StripScene scene;
  TrueFrames truth(scene.truth, *scene.flight.camera);
  EXPECT_EQ(score_track(scene.flight, {}, truth).points, 0U);
}

}  // namespace
}  // namespace ilp::score
