// The pair of keyframes that a strip begins with: which of two motions over a plane it was, and when it is passed over.
#include <gtest/gtest.h>

#include "tests/unit/vision/multiview/sequence_run.hpp"
#include "tests/unit/vision/multiview/strip_from_places.hpp"

namespace ilp {
namespace {

using test::StripKeyframe;
using test::SyntheticStrip;

/// Climbs or sinks obliquely, so that visibility leaves both motions.
std::vector<Vec3> oblique_track(unsigned seed) {
  const double rise = seed % 2 == 0 ? 0.18 : -0.18;
  return {{0, 0, 1},
          {0.17, 0.03, 1 + rise},
          {0.30, 0.15, 1 + 1.2 * rise},
          {0.45, 0.20, 1 + 1.3 * rise},
          {0.60, 0.18, 1 + 1.5 * rise},
          {0.75, 0.15, 1 + 1.7 * rise}};
}

void add(Sequence& sequence, const SyntheticStrip& strip, std::size_t k, SequenceReport& report) {
  const StripKeyframe& frame = strip.keyframes[k];
  ASSERT_TRUE(sequence.add_keyframe(static_cast<std::int64_t>(100 + k), frame.corners, frame.matches, k, report).ok());
}

/// Angle between the first step as estimated and as it was, degrees.
double first_step_error_deg(const Sequence& sequence, const SyntheticStrip& strip) {
  const RigidTransform& a = strip.keyframes[0].truth;
  const Vec3 truth = a.rotation * (inverse(strip.keyframes[1].truth).translation - inverse(a).translation);
  const Vec3 estimated = Vec3(1, -1, -1).asDiagonal() * vector_of(sequence.cameras()[1].pose.centre);
  return 180 / 3.14159265358979 * std::atan2(truth.cross(estimated).norm(), truth.dot(estimated));
}

TEST(SequenceFirstPair, TheThirdViewTellsTheMotionOverAPlaneWhicheverWasTakenFirst) {
  int wrong_at_first = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const SyntheticStrip strip = test::strip_from_places(oblique_track(seed), seed);
    Sequence sequence(test::sequence_state, test::sequence_workspace);
    ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
    SequenceReport report;
    add(sequence, strip, 0, report);
    add(sequence, strip, 1, report);
    ASSERT_EQ(report.verdict, SequenceVerdict::ok)
        << seed << ": " << name_of(report.two_view.verdict) << ", " << report.two_view.inliers << " of "
        << report.matches << ", parallax " << report.two_view.median_parallax_px << " px, direction "
        << report.two_view.sigma_direction_rad;
    if (first_step_error_deg(sequence, strip) > 8) ++wrong_at_first;
    add(sequence, strip, 2, report);
    EXPECT_EQ(report.verdict, SequenceVerdict::ok) << seed << name_of(report.verdict);
    EXPECT_LT(first_step_error_deg(sequence, strip), 4) << seed;
    for (std::size_t k = 3; k < strip.keyframes.size(); ++k) {
      add(sequence, strip, k, report);
      EXPECT_EQ(report.verdict, SequenceVerdict::ok) << seed;
      test::Collected ignored;
      test::collect(sequence, ignored);
    }
    EXPECT_LT(test::worst_error_percent(strip, test::run(strip)), 1) << seed;
  }
  EXPECT_GE(wrong_at_first, 3) << "the wrong motion must have come first now and then, or nothing was tested";
  std::printf("the wrong motion was taken first in %d of 20\n", wrong_at_first);
}

TEST(SequenceFirstPair, AThirdViewFromWhereTheFirstWasTakenDecidesNothingAndALaterOneDoesForAll) {
  int wrong_until_the_fourth = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::vector<Vec3> centres = oblique_track(seed);
    centres.insert(centres.begin() + 2, centres[0]);
    centres.pop_back();
    const SyntheticStrip strip = test::strip_from_places(centres, seed);
    for (const double height : {0.0, 250.0}) {
      SequenceParams params{.first_height = height};
      Sequence sequence(test::sequence_state, test::sequence_workspace);
      ASSERT_TRUE(sequence.begin_strip(strip.camera, params).ok());
      SequenceReport report;
      for (std::size_t k = 0; k < 3; ++k) add(sequence, strip, k, report);
      // It has a pose already, which is not final: the question is open.
      EXPECT_EQ(report.verdict, SequenceVerdict::ok) << seed << name_of(report.verdict);
      EXPECT_TRUE(test::sequence_state.first_pair.ambiguous) << seed;
      if (first_step_error_deg(sequence, strip) > 8) ++wrong_until_the_fourth;
      add(sequence, strip, 3, report);
      EXPECT_FALSE(test::sequence_state.first_pair.ambiguous) << seed;
      EXPECT_LT(first_step_error_deg(sequence, strip), 4) << seed;
      const test::Collected out = test::run(strip, params);
      EXPECT_EQ(out.cameras.size(), strip.keyframes.size()) << seed;
      EXPECT_LT(test::worst_error_percent(strip, out), 1) << seed;
    }
  }
  EXPECT_GE(wrong_until_the_fourth, 6) << "the wrong motion must have been taken now and then, or nothing was tested";
}

TEST(SequenceFirstPair, NothingIsFinalWhileTheFirstMotionIsOpen) {
  std::vector<Vec3> centres = oblique_track(1);
  centres.insert(centres.begin() + 2, centres[0]);
  const SyntheticStrip strip = test::strip_from_places(centres, 1);
  SequenceParams params{.window_keyframes = 2};
  Sequence sequence(test::sequence_state, test::sequence_workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, params).ok());
  SequenceReport report;
  SequenceCamera camera;
  for (std::size_t k = 0; k < 3; ++k) add(sequence, strip, k, report);
  ASSERT_TRUE(test::sequence_state.first_pair.ambiguous);
  EXPECT_FALSE(sequence.take_final_camera(camera));
  add(sequence, strip, 3, report);
  EXPECT_TRUE(sequence.take_final_camera(camera));
  EXPECT_TRUE(sequence.take_final_camera(camera));
  EXPECT_FALSE(sequence.take_final_camera(camera));
}

TEST(SequenceFirstPair, ADescentPosesEveryKeyframeThoughNoViewMayEverTellTheMotions) {
  // Along the normal of the plane both motions are one; near it perhaps no later view distinguishes them.
  int open = 0;
  for (const double drift : {0.0, 0.1, 0.4}) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      std::vector<Vec3> centres;
      for (int i = 0; i < 7; ++i) centres.emplace_back(0.1 * drift * i, 0, 1 - 0.1 * i);
      const SyntheticStrip strip = test::strip_from_places(centres, seed);
      Sequence sequence(test::sequence_state, test::sequence_workspace);
      ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
      SequenceReport report;
      for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
        add(sequence, strip, k, report);
        EXPECT_LE(report.verdict, SequenceVerdict::waiting) << "drift " << drift << ", seed " << seed << ", " << k;
        if (k == 2 && test::sequence_state.first_pair.ambiguous) {
          EXPECT_GT(drift, 0.3) << seed;
          ++open;
        }
        if (k > 2) {
          EXPECT_FALSE(test::sequence_state.first_pair.ambiguous) << "drift " << drift << ", seed " << seed;
        }
        test::Collected ignored;
        test::collect(sequence, ignored);
      }
    }
  }
  EXPECT_GE(open, 1) << "some third view must have told nothing, or nothing was tested";
}

TEST(SequenceFirstPair, TheRivalKeepsTheScaleOfTheAltimeter) {
  SequenceParams params{.first_height = 250};
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const SyntheticStrip strip = test::strip_from_places(oblique_track(seed), seed);
    const test::Collected out = test::run(strip, params);
    ASSERT_EQ(out.cameras.size(), strip.keyframes.size());
    const test::Truth truth = test::compare(strip, out);
    const double flown = (truth.estimated[2] - truth.estimated[0]).norm();
    EXPECT_NEAR(flown / (truth.actual[2] - truth.actual[0]).norm(), 250, 12) << seed;
  }
}

}  // namespace
}  // namespace ilp
