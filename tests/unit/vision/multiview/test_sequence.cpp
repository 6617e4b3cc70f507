#include "fsw/base/argument.hpp"
#include "fsw/vision/multiview/sequence.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <memory>
#include <set>

#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "tests/unit/vision/multiview/sequence_run.hpp"

namespace ilp {
namespace {

using test::collect;
using test::Collected;
using test::compare;
using test::run;
using test::StripScene;
using test::SyntheticStrip;
using test::Truth;
using test::worst_error_percent;

SequenceState& state = test::sequence_state;
SequenceWorkspace& workspace = test::sequence_workspace;

void expect_good(const StripScene& scene, double bound_percent = 0.3) {
  const SyntheticStrip strip(scene);
  const Collected out = run(strip);
  for (std::size_t k = 0; k < out.reports.size(); ++k) {
    EXPECT_EQ(out.reports[k].verdict, k == 0 ? SequenceVerdict::waiting : SequenceVerdict::ok)
        << k << ": " << name_of(out.reports[k].verdict);
    if (k >= 2) {
      EXPECT_NEAR(out.reports[k].scale_step, 1, 0.1) << k;
      EXPECT_GE(out.reports[k].known_points, out.reports[k].resection_inliers) << k;
      EXPECT_LE(out.reports[k].known_points, out.reports[k].two_view.inliers) << k;
    }
  }
  ASSERT_EQ(out.cameras.size(), strip.keyframes.size());
  const double error = worst_error_percent(strip, out);
  std::printf("worst position error %.3f %% of the length, %zu points\n", error, out.points.size());
  EXPECT_LT(error, bound_percent);
}

TEST(Sequence, StraightStripOverOnePercentRelief) {
  expect_good({.relief = 0.01});
}
TEST(Sequence, StraightStripOverTenPercentRelief) {
  expect_good({.relief = 0.1});
}
TEST(Sequence, StraightStripOverAPlane) {
  expect_good({.relief = 0});
}
TEST(Sequence, TurningStrip) {
  expect_good({.yaw_per_frame = 0.15});
}
TEST(Sequence, ClimbingStrip) {
  expect_good({.climb = 0.3});
}
TEST(Sequence, SparseOverlap) {
  expect_good({.keyframes = 15, .overlap = 0.6}, 1.0);
}

TEST(Sequence, FinalPointsLieOnTheGround) {
  const StripScene scene{.keyframes = 15, .relief = 0.1};
  const SyntheticStrip strip(scene);
  const Collected out = run(strip);
  const Truth truth = compare(strip, out);
  const test::Alignment world = test::align(truth.estimated, truth.actual);
  std::vector<double> errors;
  for (const FinalPoint& point : out.points) {
    ASSERT_GE(point.observations.size(), 2U);
    EXPECT_LT(point.error_px, 2);
    const Eigen::Vector3d x = world * vector_of(point.position);
    errors.push_back(std::abs(x.z() - SyntheticStrip::ground(x.x(), x.y(), scene.relief)));
  }
  ASSERT_GT(errors.size(), 500U);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.01) << "median, of a height of 1";
  EXPECT_LT(errors[errors.size() * 98 / 100], 0.05);
}

TEST(Sequence, DropsObservationsThatSlideAlongTheEpipolarLine) {
  // No two-view test sees them, and a loose resection takes them: the adjustment must, and must spare their points.
  SyntheticStrip strip({.keyframes = 12, .tilt = 0, .wrong = 0});
  std::mt19937 random(5);
  std::size_t slid = 0;
  for (std::size_t k = 3; k < strip.keyframes.size(); ++k) {
    for (Match& m : strip.keyframes[k].matches) {
      if (random() % 20 != 0) continue;
      m.xb += 6;  // along the flight
      ++slid;
    }
  }
  SequenceParams params{.resection_threshold_px = 12};
  const Collected out = run(strip, params);
  std::uint32_t dropped = 0;
  std::uint32_t lost = 0;
  for (const SequenceReport& report : out.reports) {
    dropped += report.dropped_observations;
    lost += report.lost_points;
  }
  EXPECT_NEAR(dropped, static_cast<double>(slid), 0.25 * static_cast<double>(slid)) << "each once, and little else";
  EXPECT_LT(lost, slid / 10);
  ASSERT_EQ(out.cameras.size(), 12U);
  EXPECT_LT(worst_error_percent(strip, out), 0.3);
}

TEST(Sequence, FinalPointsComeOnceWithObservationsOfFinalCameras) {
  const SyntheticStrip strip({.keyframes = 12});
  Sequence sequence(state, workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  std::set<std::int64_t> final_ids;
  std::set<std::pair<std::int64_t, std::pair<float, float>>> observations;
  for (std::size_t k = 0; k <= strip.keyframes.size(); ++k) {
    if (k < strip.keyframes.size()) {
      SequenceReport report;
      ASSERT_TRUE(sequence
                      .add_keyframe(static_cast<std::int64_t>(k), strip.keyframes[k].corners,
                                    strip.keyframes[k].matches, k, report)
                      .ok());
    } else {
      ASSERT_TRUE(sequence.flush().ok());
    }
    Collected now;
    collect(sequence, now);
    for (const SequenceCamera& camera : now.cameras) final_ids.insert(camera.keyframe_id);
    for (const FinalPoint& point : now.points) {
      for (const FinalObservation& o : point.observations) {
        EXPECT_TRUE(final_ids.count(o.keyframe_id) == 1);
        EXPECT_TRUE(observations.insert({o.keyframe_id, {o.x, o.y}}).second) << "an observation has one point";
      }
    }
  }
  EXPECT_EQ(final_ids.size(), 12U);
}

TEST(Sequence, FinalCamerasNeverChange) {
  const SyntheticStrip strip({.keyframes = 20});
  Sequence sequence(state, workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  std::map<std::int64_t, Pose> final_poses;
  Collected out;
  for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
    SequenceReport report;
    ASSERT_TRUE(sequence
                    .add_keyframe(static_cast<std::int64_t>(k), strip.keyframes[k].corners, strip.keyframes[k].matches,
                                  k, report)
                    .ok());
    for (const SequenceCamera& camera : sequence.cameras()) {
      const auto known = final_poses.find(camera.keyframe_id);
      if (known != final_poses.end()) {
        EXPECT_EQ(std::memcmp(&known->second, &camera.pose, sizeof(Pose)), 0) << camera.keyframe_id << " at " << k;
      }
      if (camera.final_pose) final_poses[camera.keyframe_id] = camera.pose;
    }
    collect(sequence, out);
    EXPECT_EQ(out.cameras.size(), k + 1 > 5 ? k + 1 - 5 : 0) << "final when it leaves a window of five";
  }
  ASSERT_TRUE(sequence.flush().ok());
  collect(sequence, out);
  ASSERT_EQ(out.cameras.size(), 20U);
  for (std::size_t k = 0; k < out.cameras.size(); ++k) {
    EXPECT_EQ(out.cameras[k].keyframe_id, static_cast<std::int64_t>(k));
  }
}

TEST(Sequence, ScaleIsOneBaselineOrTheGivenHeight) {
  const SyntheticStrip strip({.keyframes = 4});
  Collected out = run(strip);
  EXPECT_NEAR((vector_of(out.cameras[1].pose.centre) - vector_of(out.cameras[0].pose.centre)).norm(), 1, 1e-9);
  SequenceParams params{.first_height = 250};
  out = run(strip, params);
  EXPECT_NEAR(
      (inverse(strip.keyframes[2].truth).translation - inverse(strip.keyframes[0].truth).translation).norm() * 250,
      (vector_of(out.cameras[2].pose.centre) - vector_of(out.cameras[0].pose.centre)).norm(), 5);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(out.cameras[0].pose.centre[k], 0) << "the first camera is the origin";
}

TEST(Sequence, ContinuesToTheLastBitFromACopyOfAnyStep) {
  const SyntheticStrip strip({.keyframes = 9});
  const Collected expected = run(strip);
  static SequenceState copy;
  const auto other_workspace = std::make_unique<SequenceWorkspace>();
  Collected out;
  // Every step works on a fresh copy of the bytes, and with a different scratch unless the step before keeps it.
  Sequence first(state, workspace);
  ASSERT_TRUE(first.begin_strip(strip.camera, {}).ok());
  bool swap = false;
  for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
    Sequence now(state, workspace);
    ASSERT_TRUE(now.begin_keyframe(static_cast<std::int64_t>(100 + k), strip.keyframes[k].corners,
                                   strip.keyframes[k].matches, k)
                    .ok());
    while (!now.idle()) {
      std::memcpy(&copy, &state, sizeof state);
      std::memset(static_cast<void*>(&state), 0xA5, sizeof state);
      std::memcpy(&state, &copy, sizeof state);
      Sequence next(state, swap ? *other_workspace : workspace);
      ASSERT_TRUE(next.step().ok());
      swap = swap != !next.keeps();
    }
    collect(now, out);
  }
  Sequence last(state, workspace);
  ASSERT_TRUE(last.flush().ok());
  collect(last, out);
  ASSERT_EQ(out.cameras.size(), expected.cameras.size());
  for (std::size_t k = 0; k < out.cameras.size(); ++k) {
    EXPECT_EQ(std::memcmp(&out.cameras[k].pose, &expected.cameras[k].pose, sizeof(Pose)), 0) << k;
  }
  ASSERT_EQ(out.points.size(), expected.points.size());
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    EXPECT_EQ(std::memcmp(out.points[i].position, expected.points[i].position, sizeof out.points[i].position), 0);
  }
}

TEST(Sequence, StepsAreBounded) {
  constexpr int most_slices_of_a_pair = 12;  // of a good pair: a few for each search, and three more
  const SyntheticStrip strip({.keyframes = 6});
  Sequence sequence(state, workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
    ASSERT_TRUE(
        sequence.begin_keyframe(static_cast<std::int64_t>(k), strip.keyframes[k].corners, strip.keyframes[k].matches, k)
            .ok());
    EXPECT_TRUE(sequence.begin_keyframe(7, strip.keyframes[k].corners, strip.keyframes[k].matches, k)
                    .is(StatusCode::not_ready));
    EXPECT_TRUE(sequence.flush().is(StatusCode::not_ready));
    int steps = 0;
    for (; !sequence.idle() && steps < 100; ++steps) ASSERT_TRUE(sequence.step().ok());
    EXPECT_LE(steps, 5 + 20 + 5 + 2 + most_slices_of_a_pair);
    Collected out;
    collect(sequence, out);
  }
}

/// Pose and structure, without the report and what a failed keyframe brought along.
bool same_strip(const SequenceState& a, const SequenceState& b) {
  return std::memcmp(&a.cameras, &b.cameras, sizeof a.cameras) == 0 &&
         std::memcmp(&a.tracks, &b.tracks, sizeof a.tracks) == 0 &&
         std::memcmp(&a.corners, &b.corners, sizeof a.corners) == 0;
}

TEST(Sequence, AFailedKeyframeLeavesTheStripAsItWas) {
  const SyntheticStrip strip({.keyframes = 12});
  const SyntheticStrip elsewhere({.keyframes = 12, .seed = 77});
  Sequence sequence(state, workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  SequenceReport report;
  Collected out;
  static SequenceState before;
  static Matches none;
  for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
    const test::StripKeyframe& frame = strip.keyframes[k];
    if (k >= 2) {
      // Warm up the removal of handed-out tracks, which every begin_keyframe does.
      compact(state.tracks);
      state.point_cursor = 0;
      before = state;
      ASSERT_TRUE(sequence.add_keyframe(900, frame.corners, none, k, report).ok());
      EXPECT_EQ(report.verdict, SequenceVerdict::too_few_matches);
      EXPECT_TRUE(same_strip(before, state));
      // Matches with corners of another place.
      static Matches wrong;
      wrong = frame.matches;
      for (std::size_t i = 0; i < wrong.size(); ++i) {
        const Corner& c = elsewhere.keyframes[k].corners[i % elsewhere.keyframes[k].corners.size()];
        wrong[i].xb = c.x;
        wrong[i].yb = c.y;
      }
      ASSERT_TRUE(sequence.add_keyframe(901, frame.corners, wrong, k, report).ok());
      EXPECT_TRUE(report.verdict == SequenceVerdict::resection_failed ||
                  report.verdict == SequenceVerdict::implausible);
      EXPECT_TRUE(same_strip(before, state));
    }
    ASSERT_TRUE(
        sequence.add_keyframe(static_cast<std::int64_t>(100 + k), frame.corners, frame.matches, k, report).ok());
    EXPECT_EQ(report.verdict, k == 0 ? SequenceVerdict::waiting : SequenceVerdict::ok);
    collect(sequence, out);
  }
  ASSERT_TRUE(sequence.flush().ok());
  collect(sequence, out);
  ASSERT_EQ(out.cameras.size(), 12U);
  EXPECT_LT(worst_error_percent(strip, out), 0.5);
}

TEST(Sequence, FirstPairWithoutParallaxWaitsForTheNextKeyframe) {
  const SyntheticStrip strip({.keyframes = 2, .wrong = 0});
  Sequence sequence(state, workspace);
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  SequenceReport report;
  ASSERT_TRUE(sequence.add_keyframe(1, strip.keyframes[0].corners, {}, 1, report).ok());
  EXPECT_EQ(report.verdict, SequenceVerdict::waiting);
  static Matches same;
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.1F);
  for (std::uint16_t i = 0; i < 300; ++i) {
    const Corner& c = strip.keyframes[0].corners[i];
    (void)same.push_back({i, i, 0.9F, c.x + noise(random), c.y + noise(random)});
  }
  ASSERT_TRUE(sequence.add_keyframe(2, strip.keyframes[0].corners, same, 2, report).ok());
  EXPECT_EQ(report.verdict, SequenceVerdict::waiting);
  EXPECT_EQ(report.two_view.verdict, TwoViewVerdict::too_little_parallax);
  EXPECT_FALSE(sequence.begun());
  ASSERT_TRUE(sequence.add_keyframe(3, strip.keyframes[1].corners, strip.keyframes[1].matches, 3, report).ok());
  EXPECT_EQ(report.verdict, SequenceVerdict::ok);
  ASSERT_EQ(sequence.cameras().size(), 3U);
  for (const SequenceCamera& camera : sequence.cameras()) EXPECT_TRUE(camera.posed) << camera.keyframe_id;
}

TEST(Sequence, RejectsStepsBeyondTheBounds) {
  const SyntheticStrip strip({.keyframes = 6, .wrong = 0});
  const auto verdict_with = [&](const SequenceParams& params) {
    Sequence sequence(state, workspace);
    EXPECT_TRUE(sequence.begin_strip(strip.camera, params).ok());
    SequenceReport report;
    for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
      const test::StripKeyframe& frame = strip.keyframes[k];
      EXPECT_TRUE(sequence.add_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, k, report).ok());
      if (report.verdict == SequenceVerdict::implausible) break;
      Collected out;
      collect(sequence, out);
    }
    return report.verdict;
  };
  EXPECT_EQ(verdict_with({}), SequenceVerdict::ok);
  SequenceParams tilt{.max_tilt_step_rad = 0.02};
  EXPECT_EQ(verdict_with(tilt), SequenceVerdict::implausible) << "it swings by more";
  SequenceParams step{.max_step_footprints = 0.1};
  EXPECT_EQ(verdict_with(step), SequenceVerdict::implausible) << "it flies 0.18 footprints a step";
}

TEST(Sequence, CountsWhatDoesNotFit) {
  // More corners than the track table holds over a window.
  const SyntheticStrip strip({.keyframes = 12, .overlap = 0.6, .wrong = 0, .corners = 2600});
  SequenceParams params{.window_keyframes = 8};
  const Collected out = run(strip, params);
  std::uint32_t lost = 0;
  for (const SequenceReport& report : out.reports) lost += report.evicted_tracks + report.refused_tracks;
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(out.cameras.size(), 12U);
  EXPECT_LT(worst_error_percent(strip, out), 0.5);
}

TEST(Sequence, HoveringStripOutlivesTheTrackLength) {
  // Overlap of 97 %: points stay in view for more keyframes than a track or the camera list remembers.
  const SyntheticStrip strip({.keyframes = 40, .overlap = 0.97, .noise_px = 0.1});
  const Collected out = run(strip);
  std::uint32_t shortened = 0;
  for (const SequenceReport& report : out.reports) shortened += report.shortened_tracks;
  EXPECT_GT(shortened, 0U);
  ASSERT_EQ(out.cameras.size(), 40U);
  EXPECT_LT(worst_error_percent(strip, out), 1);
}

TEST(Sequence, RefusesBadInput) {
  const SyntheticStrip strip({.keyframes = 3});
  Sequence sequence(state, workspace);
  SequenceParams params{.window_keyframes = limits::max_window_keyframes + 1};
  EXPECT_TRUE(sequence.begin_strip(strip.camera, params).is(StatusCode::invalid_argument));
  CameraModel camera = strip.camera;
  camera.fx = -1;
  EXPECT_TRUE(sequence.begin_strip(camera, {}).is(StatusCode::invalid_argument));
  ASSERT_TRUE(sequence.begin_strip(strip.camera, {}).ok());
  SequenceReport report;
  ASSERT_TRUE(sequence.add_keyframe(1, strip.keyframes[0].corners, {}, 1, report).ok());
  static Matches matches;
  const auto refused = [&] {
    return static_cast<Argument>(sequence.begin_keyframe(2, strip.keyframes[1].corners, matches, 2).a);
  };
  matches = strip.keyframes[1].matches;
  matches[3].a = limits::max_corners;
  EXPECT_EQ(refused(), Argument::match);
  matches = strip.keyframes[1].matches;
  matches[3].b = matches[4].b;
  EXPECT_EQ(refused(), Argument::match);
  matches = strip.keyframes[1].matches;
  matches[3].xb = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(refused(), Argument::corner);
  ASSERT_TRUE(sequence.add_keyframe(2, strip.keyframes[1].corners, strip.keyframes[1].matches, 2, report).ok());
  EXPECT_EQ(report.verdict, SequenceVerdict::ok) << "refused input must not disturb the strip";
}

}  // namespace
}  // namespace ilp
