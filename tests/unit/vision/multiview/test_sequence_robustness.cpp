// Strips that are not nominal: turning, climbing, with things that move on the ground; and input that cannot be solved.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/unit/vision/multiview/sequence_run.hpp"
#include "tests/unit/vision/multiview/strip_from_places.hpp"

namespace ilp {
namespace {

using test::StripScene;
using test::SyntheticStrip;

test::Collected expect_all_posed(const SyntheticStrip& strip, double bound_percent) {
  test::Collected out = test::run(strip);
  for (std::size_t k = 1; k < out.reports.size(); ++k) {
    EXPECT_EQ(out.reports[k].verdict, SequenceVerdict::ok) << k << ": " << name_of(out.reports[k].verdict);
  }
  EXPECT_EQ(out.cameras.size(), strip.keyframes.size());
  const double error = test::worst_error_percent(strip, out);
  std::printf("worst position error %.3f %% of the length\n", error);
  EXPECT_LT(error, bound_percent);
  return out;
}

TEST(SequenceRobustness, AnyYawBetweenKeyframes) {
  for (const double yaw : {std::numbers::pi / 4, std::numbers::pi / 2, std::numbers::pi}) {
    expect_all_posed(SyntheticStrip({.keyframes = 15, .relief = 0.02, .yaw_per_frame = yaw, .overlap = 0.85}), 0.3);
  }
}

TEST(SequenceRobustness, ClimbAndSinkByThirtyPercent) {
  expect_all_posed(SyntheticStrip({.relief = 0, .climb = 0.3}), 0.3);
  expect_all_posed(SyntheticStrip({.relief = 0.05, .climb = -0.3}), 0.3);
}

// The camera flies to where it looks: no epipole outside the image, and no parallax around the middle.
TEST(SequenceRobustness, FlyingStraightDownAlongTheOpticalAxis) {
  const std::vector<Vec3> descent{{0, 0, 1}, {0, 0, 0.88}, {0, 0, 0.77}, {0, 0, 0.68}, {0, 0, 0.6}, {0, 0, 0.53}};
  for (unsigned seed = 1; seed <= 10; ++seed) {
    expect_all_posed(test::strip_from_places(descent, seed, 0.3, 0.02), 1);
  }
}

// Across the flight what moves leaves its epipolar line; along the flight it looks like something tall.
TEST(SequenceRobustness, OneCornerInTwentyMovesAcrossTheFlight) {
  const StripScene scene{.keyframes = 20, .relief = 0, .moving = 0.05, .moving_y = 0.02};
  const test::Collected out = expect_all_posed(SyntheticStrip(scene), 0.3);
  for (const FinalPoint& point : out.points) EXPECT_LT(point.error_px, 2);
}
TEST(SequenceRobustness, OneCornerInTwentyMovesAlongTheFlight) {
  expect_all_posed(SyntheticStrip({.keyframes = 20, .relief = 0, .moving = 0.05, .moving_x = 0.03}), 0.3);
}

TEST(SequenceRobustness, HeavyTailsOfTheMatchesCostLessThanWithoutALoss) {
  SequenceParams squares;
  squares.robust_px = 0;
  double with_default = 0;
  double with_squares = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const SyntheticStrip strip({.keyframes = 15, .noise_px = 0.08, .tails = 0.15, .wrong = 0, .seed = seed});
    with_default += test::worst_error_percent(strip, test::run(strip));
    with_squares += test::worst_error_percent(strip, test::run(strip, squares));
  }
  std::printf("worst position error, mean of six strips: %.3f %%, least squares %.3f %%\n", with_default / 6,
              with_squares / 6);
  EXPECT_LT(with_default, 0.9 * with_squares);
}

/// The strip's keyframes [0, count), so that the next one can be tampered with.
void begin_with(Sequence& sequence, const SyntheticStrip& strip, std::size_t count) {
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  SequenceReport report;
  for (std::size_t k = 0; k < count; ++k) {
    const test::StripKeyframe& frame = strip.keyframes[k];
    ASSERT_TRUE(sequence.add_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, k, report).ok());
    test::Collected out;
    test::collect(sequence, out);
  }
  ASSERT_EQ(sequence.cameras().size(), count);
}

double distance_of_last_two(const Sequence& sequence) {
  const auto& cameras = sequence.cameras();
  const std::size_t last = cameras.size() - 1;
  return (vector_of(cameras[last].pose.centre) - vector_of(cameras[last - 1].pose.centre)).norm();
}

/// Corners of `previous` seen again by a camera turned by `turn` at the same place, and all matches with them.
void turn_camera(const CameraModel& camera, const Corners& previous, const Vec3& turn, Corners& corners,
                 Matches& matches) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.1);
  const Mat3 rotation = rotation_from_vector(turn);
  corners.clear();
  matches.clear();
  for (std::size_t i = 0; i < previous.size(); ++i) {
    const Vec2 ideal = normalised_from_ideal(camera, ideal_from_pixel(camera, Vec2(previous[i].x, previous[i].y)));
    const Vec3 ray = rotation * Vec3(ideal.x(), ideal.y(), 1);
    const Vec2 pixel = pixel_from_normalised(camera, Vec2(ray.x() / ray.z(), ray.y() / ray.z()));
    if (pixel.x() < 8 || pixel.y() < 8 || pixel.x() > 631 || pixel.y() > 471) continue;
    const auto index = static_cast<std::uint16_t>(corners.size());
    const auto x = static_cast<float>(pixel.x() + noise(random));
    const auto y = static_cast<float>(pixel.y() + noise(random));
    (void)corners.push_back({x, y, 1});
    (void)matches.push_back({static_cast<std::uint16_t>(i), index, 0.9F, x, y});
  }
}

TEST(SequenceRobustness, ACameraThatOnlyTurnsBeginsNoStructureAndStaysWhereItIsInOne) {
  const SyntheticStrip strip({.keyframes = 6, .wrong = 0});
  static Corners corners;
  static Matches matches;
  for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(0.05, -0.03, 0.2)}) {
    Sequence sequence(test::sequence_state, test::sequence_workspace);
    begin_with(sequence, strip, 1);
    SequenceReport report;
    turn_camera(strip.camera, test::sequence_state.corners, turn, corners, matches);
    ASSERT_TRUE(sequence.add_keyframe(50, corners, matches, 50, report).ok());
    EXPECT_EQ(report.verdict, SequenceVerdict::waiting);
    EXPECT_EQ(report.two_view.verdict, TwoViewVerdict::too_little_parallax);
    EXPECT_FALSE(sequence.begun());

    begin_with(sequence, strip, 5);
    turn_camera(strip.camera, test::sequence_state.corners, turn, corners, matches);
    ASSERT_TRUE(sequence.add_keyframe(50, corners, matches, 50, report).ok());
    EXPECT_EQ(report.verdict, SequenceVerdict::ok);
    EXPECT_EQ(report.two_view.verdict, TwoViewVerdict::too_little_parallax);
    EXPECT_LT(distance_of_last_two(sequence), 0.02) << "baselines";
  }
}

TEST(SequenceRobustness, MatchesOnALineGiveNoPose) {
  const SyntheticStrip strip({.keyframes = 6, .relief = 0, .wrong = 0, .corners = 2000});
  static Matches on_line;
  for (const std::size_t before : {std::size_t{1}, std::size_t{5}}) {
    Sequence sequence(test::sequence_state, test::sequence_workspace);
    begin_with(sequence, strip, before);
    const test::StripKeyframe& frame = strip.keyframes[before];
    on_line.clear();
    for (const Match& m : frame.matches) {
      if (std::abs(test::sequence_state.corners[m.a].y - 240) < 4) (void)on_line.push_back(m);
    }
    ASSERT_GE(on_line.size(), 20U);
    SequenceReport report;
    ASSERT_TRUE(sequence.add_keyframe(50, frame.corners, on_line, 50, report).ok());
    EXPECT_NE(report.verdict, SequenceVerdict::ok) << "after " << before << " keyframes";
    EXPECT_EQ(sequence.begun(), before > 1);
    if (before > 1) {
      EXPECT_EQ(sequence.cameras().size(), before);
    }
  }
}

TEST(SequenceRobustness, SevenMatchesAreTooFew) {
  const SyntheticStrip strip({.keyframes = 6, .wrong = 0});
  static Matches few;
  for (const std::size_t before : {std::size_t{1}, std::size_t{5}}) {
    Sequence sequence(test::sequence_state, test::sequence_workspace);
    begin_with(sequence, strip, before);
    few.clear();
    for (std::size_t i = 0; i < 7; ++i) (void)few.push_back(strip.keyframes[before].matches[i]);
    SequenceReport report;
    ASSERT_TRUE(sequence.add_keyframe(50, strip.keyframes[before].corners, few, 50, report).ok());
    EXPECT_EQ(report.verdict, SequenceVerdict::too_few_matches);
  }
}

// Near the plane a wrong focal length hides in heights and attitudes and shows in no residual . What it must not do is
// break the strip or bend the track.
TEST(SequenceRobustness, AFocalLengthThatIsWrongByATenthLeavesTheTrackStraight) {
  for (const double tilt : {0.0, 0.03}) {
    SyntheticStrip strip({.keyframes = 12, .relief = 0.05, .tilt = tilt, .noise_px = 0.1, .wrong = 0});
    const double right = test::run(strip).reports.back().rms_px;
    strip.camera.fx *= 1.1;
    strip.camera.fy *= 1.1;
    const test::Collected out = expect_all_posed(strip, 2);
    std::printf("tilt %.2f: rms %.3f px with the right focal length, %.3f px with the wrong one\n", tilt, right,
                out.reports.back().rms_px);
  }
}

}  // namespace
}  // namespace ilp
