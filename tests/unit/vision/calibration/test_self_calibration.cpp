// Self-calibration on simulated flights: right where the motion determines the focal length, without an answer where it
// does not.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "fsw/base/argument.hpp"
#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "fsw/vision/calibration/self_calibration.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "tests/unit/vision/calibration/synthetic_flight.hpp"

namespace ilp::test {
namespace {

class SelfCalibrationTest : public ::testing::Test {
 protected:
  /// All keyframes until the first answer.
  CalibrationReport fly(const SyntheticFlight& flight) {
    SelfCalibration calibration(*state_, *workspace_);
    EXPECT_TRUE(calibration.begin(flight.nominal, {}).ok());
    CalibrationReport report;
    for (std::size_t k = 0; k < flight.keyframes.size(); ++k) {
      const FlightKeyframe& frame = flight.keyframes[k];
      EXPECT_TRUE(
          calibration.add_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, 1000 + k, report).ok());
      if (report.verdict == CalibrationVerdict::ok) break;
    }
    return report;
  }

  std::unique_ptr<CalibrationState> state_ = std::make_unique<CalibrationState>();
  std::unique_ptr<CalibrationWorkspace> workspace_ = std::make_unique<CalibrationWorkspace>();
};

FlightScene swinging(unsigned seed) {
  FlightScene scene;
  scene.seed = seed;
  scene.swing_rad = 0.1;
  scene.keyframes = 8;
  return scene;
}

TEST_F(SelfCalibrationTest, FindsTheFocalLengthOfASwingingFlightOverACanyon) {
  int answers = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    FlightScene scene = swinging(seed);
    scene.field_of_view_rad = 0.8 + 0.1 * seed;
    const SyntheticFlight flight(scene);
    const CalibrationReport report = fly(flight);
    if (report.verdict != CalibrationVerdict::ok) continue;
    ++answers;
    EXPECT_NEAR(report.camera.fx, flight.camera.fx, 0.012 * flight.camera.fx) << seed;
    EXPECT_LT(std::abs(report.camera.fx - flight.camera.fx), 3 * report.sigma_focal_px) << seed;
    EXPECT_EQ(report.camera.fy, report.camera.fx);
    EXPECT_NEAR(report.noise_px, scene.noise_px, 0.1) << seed;
  }
  EXPECT_GE(answers, 2);
}

TEST_F(SelfCalibrationTest, RefusesAPlaneAndSaysSo) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    FlightScene scene = swinging(seed);
    scene.world = "flat";
    const CalibrationReport report = fly(SyntheticFlight(scene));
    EXPECT_TRUE(report.verdict == CalibrationVerdict::planar ||
                report.verdict == CalibrationVerdict::too_little_parallax ||
                report.verdict == CalibrationVerdict::collecting)
        << name_of(report.verdict);
    EXPECT_EQ(report.camera.fx, 0);
  }
}

TEST_F(SelfCalibrationTest, RefusesPureTranslationOverRuggedGround) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    FlightScene scene = swinging(seed);
    scene.line = true;
    const CalibrationReport report = fly(SyntheticFlight(scene));
    EXPECT_TRUE(report.verdict == CalibrationVerdict::critical_motion ||
                report.verdict == CalibrationVerdict::inconsistent)
        << name_of(report.verdict);
  }
}

TEST_F(SelfCalibrationTest, RefusesACameraThatOnlyTurns) {
  FlightScene scene = swinging(2);
  SyntheticFlight flight(scene);
  // The first keyframe's corners again and again, turned about the camera's own centre.
  const FlightKeyframe& first = flight.keyframes[0];
  SelfCalibration calibration(*state_, *workspace_);
  ASSERT_TRUE(calibration.begin(flight.nominal, {}).ok());
  CalibrationReport report;
  for (int k = 0; k < 3; ++k) {
    const Mat3 turn = rotation_from_vector(Vec3(0.04 * k, -0.05 * k, 0.1 * k));
    Corners corners;
    Matches matches;
    for (std::size_t i = 0; i < first.corners.size(); ++i) {
      const Corner& c = first.corners[i];
      const Vec3 ray = turn * Vec3((c.x - 319.5) / 500, (c.y - 239.5) / 500, 1);
      const Corner turned{static_cast<float>(500 * ray.x() / ray.z() + 319.5),
                          static_cast<float>(500 * ray.y() / ray.z() + 239.5), 1};
      ASSERT_TRUE(corners.push_back(turned));
      const auto index = static_cast<std::uint16_t>(i);
      ASSERT_TRUE(matches.push_back({index, index, 1, turned.x, turned.y}));
    }
    ASSERT_TRUE(calibration.add_keyframe(k, corners, matches, 5, report).ok());
  }
  EXPECT_EQ(report.verdict, CalibrationVerdict::too_little_parallax);
}

/// Where a track was seen, found from matches alone: from its corner in the newest keyframe back through the set.
void expect_track_is_where_its_corners_were(const CalibrationTrack& track, const CalibrationState& state,
                                            const SyntheticFlight& flight, const std::vector<Corners>& refined) {
  const CentredFrame frame(flight.nominal);
  std::size_t corner = track.corner;
  for (std::size_t view = state.keyframes.size(); view-- > 0;) {
    if (!has_view(track.seen, view)) return;
    const auto k = static_cast<std::size_t>(state.keyframes[view]);
    EXPECT_NEAR(track.u[view], frame.u(static_cast<double>(refined[k][corner].x)), 1e-12);
    EXPECT_NEAR(track.v[view], frame.v(static_cast<double>(refined[k][corner].y)), 1e-12);
    const Matches& back = flight.keyframes[k].matches;
    const auto* const match =
        std::find_if(back.begin(), back.end(), [corner](const Match& m) { return m.b == corner; });
    if (match == back.end()) {
      EXPECT_EQ(track.seen & (only_view(view) - 1), 0) << "nothing leads further back than view " << view;
      return;
    }
    corner = match->a;
  }
}

TEST_F(SelfCalibrationTest, TheSetSlidesOverALongFlightAndTracksKeepTheirViews) {
  FlightScene scene = swinging(3);
  scene.line = true;  // never answered, so that the set goes on
  scene.keyframes = 11;
  const SyntheticFlight flight(scene);
  std::vector<Corners> refined;
  SelfCalibration calibration(*state_, *workspace_);
  ASSERT_TRUE(calibration.begin(flight.nominal, {}).ok());
  const auto most = static_cast<std::size_t>(CalibrationParams{}.max_views);
  for (std::size_t k = 0; k < flight.keyframes.size(); ++k) {
    const FlightKeyframe& at = flight.keyframes[k];
    refined.push_back(at.corners);
    refine_corners(at.matches, refined.back());
    CalibrationReport report;
    ASSERT_TRUE(calibration.add_keyframe(static_cast<std::int64_t>(k), at.corners, at.matches, 1000 + k, report).ok());
    const std::size_t views = std::min(k + 1, most);
    ASSERT_EQ(state_->keyframes.size(), views) << "the newest keyframes, as many as there is room for";
    ASSERT_EQ(state_->pairs.size(), views - 1);
    for (std::size_t v = 0; v < views; ++v)
      EXPECT_EQ(state_->keyframes[v], static_cast<std::int64_t>(k + 1 - views + v));
    for (std::size_t v = 1; v < views; ++v) {
      EXPECT_EQ(state_->pairs[v - 1].first_id, state_->keyframes[v - 1]);
      EXPECT_EQ(state_->pairs[v - 1].second_id, state_->keyframes[v]);
    }
    std::size_t newest = 0, oldest_to_newest = 0;
    for (const CalibrationTrack& track : state_->tracks) {
      EXPECT_LT(track.seen, only_view(views)) << "no view behind the newest";
      if (!has_view(track.seen, views - 1)) continue;
      ++newest;
      oldest_to_newest += has_view(track.seen, 0) ? 1 : 0;
      expect_track_is_where_its_corners_were(track, *state_, flight, refined);
    }
    if (k == 0) continue;
    EXPECT_EQ(newest, state_->pairs.back().inliers) << "keyframe " << k;
    EXPECT_GT(oldest_to_newest, 5U) << "some points are in view through the whole set, keyframe " << k;
  }
}

TEST_F(SelfCalibrationTest, GoesOnFromACheckpointWithTheSameBits) {
  const SyntheticFlight flight(swinging(2));
  const CalibrationReport whole = fly(flight);
  ASSERT_GT(whole.refined_focal_px, 0);
  const auto copy = std::make_unique<CalibrationState>();
  CalibrationReport report;
  auto fresh = std::make_unique<CalibrationWorkspace>();
  ASSERT_TRUE(SelfCalibration(*state_, *fresh).begin(flight.nominal, {}).ok());
  for (std::size_t k = 0; k < flight.keyframes.size(); ++k) {
    const FlightKeyframe& frame = flight.keyframes[k];
    ASSERT_TRUE(SelfCalibration(*state_, *fresh)
                    .begin_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, 1000 + k)
                    .ok());
    bool pending = true;
    for (int steps = 0; pending; ++steps) {
      // After a loss of all scratch in every 53rd step: a part of the verification takes 40 and then starts over.
      if (steps % 53 == 3) {
        std::memcpy(static_cast<void*>(copy.get()), state_.get(), sizeof(*copy));
        fresh = std::make_unique<CalibrationWorkspace>();
        std::memcpy(static_cast<void*>(state_.get()), copy.get(), sizeof(*copy));
      }
      const Result<bool> more = SelfCalibration(*state_, *fresh).step();
      ASSERT_TRUE(more.ok());
      pending = more.value();
    }
    report = SelfCalibration(*state_, *fresh).report();
    if (report.verdict == CalibrationVerdict::ok) break;
  }
  EXPECT_EQ(report.verdict, whole.verdict);
  EXPECT_EQ(report.refined_focal_px, whole.refined_focal_px);
  EXPECT_EQ(report.sigma_focal_px, whole.sigma_focal_px);
}

TEST_F(SelfCalibrationTest, RefusesBadInputByName) {
  const SyntheticFlight flight(swinging(2));
  SelfCalibration calibration(*state_, *workspace_);
  CalibrationParams params;
  params.max_views = limits::max_calibration_views + 1;
  EXPECT_TRUE(calibration.begin(flight.nominal, params).is(StatusCode::invalid_argument));
  ASSERT_TRUE(calibration.begin(flight.nominal, {}).ok());
  CalibrationReport report;
  ASSERT_TRUE(calibration.add_keyframe(1, flight.keyframes[0].corners, {}, 1, report).ok());
  EXPECT_EQ(report.verdict, CalibrationVerdict::collecting);
  Matches twice = flight.keyframes[1].matches;
  twice[1].a = twice[0].a;
  const Status status = calibration.begin_keyframe(2, flight.keyframes[1].corners, twice, 1);
  EXPECT_TRUE(status.is(StatusCode::invalid_argument));
  EXPECT_EQ(static_cast<Argument>(status.a), Argument::match);
  EXPECT_EQ(status.b, 1000) << "the match with the number 1";
  ASSERT_TRUE(calibration.add_keyframe(2, flight.keyframes[1].corners, {}, 1, report).ok());
  EXPECT_EQ(report.verdict, CalibrationVerdict::too_few_matches);
}

}  // namespace
}  // namespace ilp::test
