// Strips whose first two keyframes cannot begin the structure: the best pair of the first five does, and the keyframes
// around it get their poses from its points.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/unit/vision/multiview/sequence_run.hpp"
#include "tests/unit/vision/multiview/strip_from_places.hpp"

namespace ilp {
namespace {

using test::SyntheticStrip;

/// `still` keyframes at the beginning of the flight, where the camera only turns, and then `steps` along it.
std::vector<Vec3> track(int still, int steps, double rise = 0) {
  std::vector<Vec3> centres;
  for (int i = 0; i < still; ++i) centres.emplace_back(0, 0, 1);
  for (int i = 1; i <= steps; ++i) centres.emplace_back(0.16 * i, 0.02 * (i % 2), 1 + rise * i);
  return centres;
}

void expect_all_posed(const SyntheticStrip& strip, double bound_percent, const SequenceParams& params = {}) {
  const test::Collected out = test::run(strip, params);
  EXPECT_TRUE(test::sequence_state.first_pair.begun);
  EXPECT_FALSE(test::sequence_state.first_pair.ambiguous);
  ASSERT_EQ(out.cameras.size(), strip.keyframes.size());
  for (std::size_t k = 0; k < out.cameras.size(); ++k) {
    EXPECT_EQ(out.cameras[k].keyframe_id, static_cast<std::int64_t>(100 + k)) << "final poses come in order";
    EXPECT_TRUE(out.cameras[k].posed);
    EXPECT_LE(out.reports[k].verdict, SequenceVerdict::waiting) << k << ": " << name_of(out.reports[k].verdict);
  }
  EXPECT_LT(test::worst_error_percent(strip, out), bound_percent);
  EXPECT_GT(out.points.size(), 100U);
}

TEST(SequenceBeginning, KeyframesBetweenWhichTheCameraOnlyTurnedGetTheirPoses) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const int still : {2, 3, 4}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << still << " from one place");
      expect_all_posed(test::strip_from_places(track(still, 6), seed, 0.1), 0.5);
    }
  }
}

TEST(SequenceBeginning, OverAPlaneTheKeyframesAroundThePairDecideBetweenItsMotions) {
  // So steep that visibility leaves both motions of any pair; not on one line.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const double rise = seed % 2 == 0 ? 0.18 : -0.18;
    const std::vector<Vec3> oblique{{0, 0, 1},
                                    {0, 0, 1},
                                    {0.17, 0.03, 1 + rise},
                                    {0.05, 0.22, 1 + 1.5 * rise},
                                    {0.20, 0.30, 1 + 1.6 * rise},
                                    {0.35, 0.30, 1 + 1.7 * rise},
                                    {0.50, 0.28, 1 + 1.8 * rise}};
    expect_all_posed(test::strip_from_places(oblique, seed, 0, 0.12), 1);
  }
}

TEST(SequenceBeginning, StepsOfLittleParallaxAddUpToAPair) {
  for (const double step : {0.002, 0.004, 0.01}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", steps of " << step);
      std::vector<Vec3> centres;
      for (int i = 0; i < 4; ++i) centres.emplace_back(step * i, 0, 1);
      for (int i = 1; i <= 5; ++i) centres.emplace_back(0.16 * i, 0, 1);
      expect_all_posed(test::strip_from_places(centres, seed, 0.1), 0.5);
    }
  }
}

/// Leaves only `kept` matches of keyframe k.
void thin_out(SyntheticStrip& strip, std::size_t k, std::size_t kept) {
  Matches few;
  const Matches& all = strip.keyframes[k].matches;
  for (std::size_t i = 0; i < kept; ++i) (void)few.push_back(all[i * all.size() / kept]);
  strip.keyframes[k].matches = few;
}

TEST(SequenceBeginning, AFirstPairOfSoFewMatchesThatNothingCanBeResectedCostsOneKeyframe) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SyntheticStrip strip = test::strip_from_places(track(1, 6), seed, 0.1);
    thin_out(strip, 1, 21);
    const test::Collected out = test::run(strip);
    EXPECT_GE(out.cameras.size(), strip.keyframes.size() - 1) << "seed " << seed;
    EXPECT_EQ(out.cameras.back().keyframe_id, 106) << "seed " << seed;
    for (const SequenceReport& report : out.reports) EXPECT_LE(report.verdict, SequenceVerdict::waiting) << seed;
  }
}

TEST(SequenceBeginning, AFirstPairOfFewMatchesIsPosedByTheNextOne) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    SyntheticStrip strip = test::strip_from_places(track(1, 6), seed, 0.1);
    thin_out(strip, 1, 45);
    expect_all_posed(strip, 1.5);
  }
}

TEST(SequenceBeginning, APairAmongTheOldestBeginsWhenTheFifthHasCome) {
  // One step, and then the camera only turns. No pair is good enough to begin at once.
  SequenceParams params{.max_first_depth_error = 1e-6};
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const std::vector<Vec3> centres{{0, 0, 1},   {0.2, 0, 1},  {0.2, 0, 1},  {0.2, 0, 1},
                                    {0.2, 0, 1}, {0.36, 0, 1}, {0.52, 0, 1}, {0.68, 0, 1}};
    const SyntheticStrip strip = test::strip_from_places(centres, seed, 0.1);
    expect_all_posed(strip, 0.5, params);
    Sequence sequence(test::sequence_state, test::sequence_workspace);
    ASSERT_TRUE(sequence.begin_strip(strip.camera, params).ok());
    for (std::size_t k = 0; k < max_first_keyframes; ++k) {
      SequenceReport report;
      const test::StripKeyframe& frame = strip.keyframes[k];
      ASSERT_TRUE(sequence.add_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, k, report).ok());
      EXPECT_EQ(sequence.begun(), k + 1 == max_first_keyframes) << k;
    }
  }
}

TEST(SequenceBeginning, AShortStripBeginsWhenItEnds) {
  SequenceParams params{.max_first_depth_error = 1e-6};
  for (const int steps : {1, 2, 3}) {
    const SyntheticStrip strip = test::strip_from_places(track(1, steps), 3, 0.1);
    const test::Collected out = test::run(strip, params);
    EXPECT_TRUE(test::sequence_state.first_pair.begun) << steps;
    ASSERT_EQ(out.cameras.size(), strip.keyframes.size());
    for (const SequenceCamera& camera : out.cameras) EXPECT_TRUE(camera.posed) << camera.keyframe_id;
    EXPECT_LT(test::worst_error_percent(strip, out), 1) << steps;
  }
  // Two keyframes over a plane leave two motions still.
  const std::vector<Vec3> oblique{{0, 0, 1}, {0.17, 0.03, 1.18}};
  (void)test::run(test::strip_from_places(oblique, 2), params);
  EXPECT_TRUE(test::sequence_state.first_pair.ambiguous);
  // A camera that only turns begins nothing.
  const test::Collected still = test::run(test::strip_from_places(track(3, 0), 3, 0.1));
  EXPECT_FALSE(test::sequence_state.first_pair.begun);
  EXPECT_EQ(still.points.size(), 0U);
}

TEST(SequenceBeginning, OfManyKeyframesFromOnePlaceTheOldestAreDropped) {
  const SyntheticStrip strip = test::strip_from_places(track(7, 5), 3, 0.1);
  Sequence sequence(test::sequence_state, test::sequence_workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  std::vector<std::int64_t> dropped;
  test::Collected out;
  for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
    const test::StripKeyframe& frame = strip.keyframes[k];
    SequenceReport report;
    ASSERT_TRUE(
        sequence.add_keyframe(static_cast<std::int64_t>(100 + k), frame.corners, frame.matches, k, report).ok());
    EXPECT_EQ(report.verdict, k < 7 ? SequenceVerdict::waiting : SequenceVerdict::ok) << k;
    for (const std::int64_t id : sequence.dropped()) dropped.push_back(id);
    test::collect(sequence, out);
  }
  test::end(sequence);
  test::collect(sequence, out);
  EXPECT_EQ(dropped, (std::vector<std::int64_t>{100, 101, 102}));
  EXPECT_EQ(out.cameras.size(), strip.keyframes.size() - dropped.size());
  EXPECT_LT(test::worst_error_percent(strip, out), 0.5);
}

TEST(SequenceBeginning, WorldAndScaleAreThoseOfTheFirstKeyframe) {
  const SyntheticStrip strip = test::strip_from_places(track(2, 6), 4, 0.02, 0.04);
  const test::Collected unit = test::run(strip);
  EXPECT_NEAR(vector_of(unit.cameras[0].pose.centre).norm(), 0, 1e-12);
  EXPECT_LT(vector_of(unit.cameras[1].pose.centre).norm(), 0.02) << "it only turned";
  EXPECT_NEAR(vector_of(unit.cameras[2].pose.centre).norm(), 1, 1e-9) << "the first real baseline is the unit";
  SequenceParams params{.first_height = 250};
  params.q_first[0] = 0.02;
  params.q_first[1] = std::sqrt(1 - 0.0004);
  const test::Collected metric = test::run(strip, params);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(metric.cameras[0].pose.q_cam_from_world[i], params.q_first[i], 1e-9);
  const test::Truth truth = test::compare(strip, metric);
  EXPECT_NEAR((truth.estimated[7] - truth.estimated[0]).norm() / (truth.actual[7] - truth.actual[0]).norm(), 250, 12);
}

TEST(SequenceBeginning, ACopyOfTheStateFromAnyStepContinuesWithTheSameResult) {
  const SyntheticStrip strip = test::strip_from_places(track(3, 4), 2);
  static SequenceState copied;
  static SequenceState wanted;
  const auto fly = [&](SequenceState& state, int copy_at, int& steps) {
    SequenceState* now = &test::sequence_state;
    EXPECT_TRUE(Sequence(*now, test::sequence_workspace).begin_strip(strip.camera, {}).ok());
    steps = 0;
    for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
      const test::StripKeyframe& frame = strip.keyframes[k];
      EXPECT_TRUE(Sequence(*now, test::sequence_workspace)
                      .begin_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, k)
                      .ok());
      for (; !Sequence(*now, test::sequence_workspace).idle(); ++steps) {
        if (steps == copy_at && !Sequence(*now, test::sequence_workspace).keeps()) {
          std::memcpy(&copied, now, sizeof(copied));
          now = &copied;
          // Whatever the workspace holds is of no use any more.
          test::sequence_workspace.pairs.clear();
          test::sequence_workspace.views.clear();
          test::sequence_workspace.pair_inliers.clear();
          test::sequence_workspace.match_of_view.fill(7);
          test::sequence_workspace.contradicts.fill(1);
          test::sequence_workspace.track_of_corner.fill(0);
        }
        EXPECT_TRUE(Sequence(*now, test::sequence_workspace).step().ok());
      }
      test::Collected ignored;
      Sequence sequence(*now, test::sequence_workspace);
      test::collect(sequence, ignored);
    }
    std::memcpy(&state, now, sizeof(state));
  };
  int count = 0;
  fly(wanted, -1, count);
  ASSERT_TRUE(wanted.first_pair.begun);
  static SequenceState found;
  for (int at = 0; at < count; ++at) {
    int same_count = 0;
    fly(found, at, same_count);
    EXPECT_EQ(same_count, count);
    ASSERT_EQ(found.cameras.size(), wanted.cameras.size());
    EXPECT_EQ(std::memcmp(&found.cameras, &wanted.cameras, sizeof(found.cameras)), 0) << "copied before step " << at;
    EXPECT_EQ(found.tracks.size(), wanted.tracks.size()) << at;
  }
}

}  // namespace
}  // namespace ilp
