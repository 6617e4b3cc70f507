// The similarity of a strip from the vehicle's measurements, against similarities that are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"
#include "tests/unit/vision/navigation/normal_numbers.hpp"

namespace ilp::navigation {
namespace {

constexpr double metre_per_foot = 0.3048;

/// A strip with a known similarity, and a vehicle whose sensors have the noise that they state.
struct TrueStrip {
  double metres_per_unit = 2.5;
  Mat3 level_from_strip = rotation_from_vector(Vec3(0, 0, 0.8)) * rotation_from_vector(Vec3(0.03, -0.02, 0));
  Vec3 origin_m{120, -40, 900};
  std::size_t keyframes = 30;
  double height_noise = 0.003, tilt_noise = 0.003, heading_noise = 0.004, position_noise = 2, velocity_noise = 0.1;
  double outliers = 0;
  bool heights = true, attitudes = true, headings = true, positions = true, velocities = true;
  std::size_t first_measured = 0, last_measured = 1000;

  [[nodiscard]] MeasuredKeyframes measure(std::uint64_t seed) const {
    Rng rng(seed);
    MeasuredKeyframes list;
    for (std::size_t i = 0; i < keyframes; ++i) {
      MeasuredKeyframe k{.keyframe_id = static_cast<std::int64_t>(i) + 1,
                         .time_ns = static_cast<TimeNs>(i) * 10 * ns_per_s};
      // Metres in the level frame: 4 m/s to the north-east, a height that changes.
      const double along = 40 * static_cast<double>(i);
      const Vec3 place = origin_m + Vec3(0.6 * along, 0.8 * along, 3 * det_sin(0.4 * static_cast<double>(i)));
      const Vec3 centre = level_from_strip.transpose() * (place - origin_m) / metres_per_unit;
      const double height = place.z() - origin_m.z() + 100;
      for (int a = 0; a < 3; ++a) k.centre[a] = centre[a];
      k.ground_distance = height / metres_per_unit;
      k.ground_distance_sigma = 1e-4 * k.ground_distance;
      RigidTransform camera;
      camera.rotation =
          Mat3(Vec3(1, -1, -1).asDiagonal()) * rotation_from_vector(0.05 * Vec3(normal(rng), normal(rng), 0));
      const Pose true_attitude = pose_from(camera);
      RigidTransform from_strip;
      from_strip.rotation = rotation_from_quaternion(true_attitude.q_cam_from_world) * level_from_strip;
      const Pose strip_attitude = pose_from(from_strip);
      for (int a = 0; a < 4; ++a) k.q_cam_from_strip[a] = strip_attitude.q_cam_from_world[a];
      const bool measured = i >= first_measured && i <= last_measured;
      const bool wrong = rng.uniform() < outliers;
      if (measured && heights) {
        k.height_m = height * (1 + height_noise * normal(rng)) * (wrong ? 0.3 + 2 * rng.uniform() : 1);
        k.height_sigma_m = height_noise * height;
      }
      if (measured && attitudes) {
        const Vec3 error(tilt_noise * normal(rng), tilt_noise * normal(rng), heading_noise * normal(rng));
        RigidTransform reported{.rotation = camera.rotation * rotation_from_vector(wrong ? Vec3(0.3, 0.2, 1) : error)};
        const Pose attitude = pose_from(reported);
        for (int a = 0; a < 4; ++a) k.q_cam_from_level[a] = attitude.q_cam_from_world[a];
        k.tilt_sigma_rad = tilt_noise;
        k.heading_sigma_rad = headings ? heading_noise : 0;
      }
      if (measured && positions) {
        for (int a = 0; a < 3; ++a) k.place_m[a] = place[a] + position_noise * normal(rng) + (wrong ? 500 : 0);
        k.horizontal_sigma_m = k.vertical_sigma_m = position_noise;
      }
      if (measured && velocities) {
        const Vec3 velocity(2.4, 3.2, 0);
        for (int a = 0; a < 3; ++a) k.velocity_m_s[a] = velocity[a] + velocity_noise * normal(rng);
        k.velocity_sigma_m_s = velocity_noise;
      }
      add_thinned(k, list);
    }
    return list;
  }
  [[nodiscard]] StripFrame estimate(std::uint64_t seed) const { return estimate_strip_frame(measure(seed)); }
  [[nodiscard]] double scale_error(const StripFrame& frame) const {
    return std::fabs(frame.metres_per_unit / metres_per_unit - 1);
  }
  [[nodiscard]] double tilt_error(const StripFrame& frame) const {
    return det_acos(frame.level_from_strip.row(2).dot(level_from_strip.row(2)));
  }
  [[nodiscard]] double heading_error(const StripFrame& frame) const {
    const Mat3 turn = frame.level_from_strip * level_from_strip.transpose();
    return std::fabs(det_atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1)));
  }
};

TEST(StripFrameTest, AllMeasurementsTogetherGiveScaleAttitudeAndPlace) {
  const TrueStrip truth;
  const StripFrame frame = truth.estimate(1);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::ok);
  EXPECT_LT(truth.scale_error(frame), 0.002);
  EXPECT_LT(truth.tilt_error(frame), 0.0017) << "0.1 degrees";
  EXPECT_LT(truth.heading_error(frame), 0.005);
  EXPECT_LT((frame.origin_m - truth.origin_m).norm(), 3);
  EXPECT_EQ(frame.heights.used, 30U);
  EXPECT_GE(frame.positions.used, 28U);
}

TEST(StripFrameTest, EveryMeasurementIsOptional) {
  TrueStrip truth{.attitudes = false, .positions = false, .velocities = false};
  StripFrame frame = truth.estimate(2);
  EXPECT_LT(truth.scale_error(frame), 0.003);
  EXPECT_EQ(frame.tilt_sigma_rad, 0);
  EXPECT_EQ(frame.heading_sigma_rad, 0);
  EXPECT_EQ(frame.horizontal_sigma_m, 0);
  EXPECT_TRUE(frame.level_from_strip == Mat3::Identity());

  truth = {};
  truth.heights = truth.positions = truth.velocities = truth.headings = false;
  frame = truth.estimate(3);
  EXPECT_LT(truth.tilt_error(frame), 0.0017);
  EXPECT_EQ(frame.heading_sigma_rad, 0);
  EXPECT_EQ(frame.scale_sigma, 0);
  EXPECT_EQ(frame.metres_per_unit, 1);

  truth = {};
  truth.heights = truth.attitudes = truth.velocities = false;
  truth.level_from_strip = rotation_from_vector(Vec3(0, 0, -2.2));
  frame = truth.estimate(4);
  EXPECT_LT(truth.scale_error(frame), 0.005);
  EXPECT_LT(truth.heading_error(frame), 0.005) << "the track says what is north";
  EXPECT_GT(frame.horizontal_sigma_m, 0);

  truth = {};
  truth.heights = truth.attitudes = truth.positions = truth.velocities = false;
  EXPECT_EQ(truth.estimate(5).verdict, StripFrameVerdict::nothing_measured);
}

TEST(StripFrameTest, MeasurementsThatBeginOrEndOnTheWayAreEnough) {
  TrueStrip truth{.first_measured = 20};
  EXPECT_LT(truth.scale_error(truth.estimate(6)), 0.004);
  truth.first_measured = 0;
  truth.last_measured = 9;
  EXPECT_LT(truth.scale_error(truth.estimate(7)), 0.004);
  truth.last_measured = 1;
  EXPECT_EQ(truth.estimate(8).verdict, StripFrameVerdict::nothing_measured) << "two keyframes are too few";
}

TEST(StripFrameTest, TenPercentOfOutliersChangeTheScaleByLessThanAThousandth) {
  TrueStrip truth, spoilt;
  truth.positions = truth.velocities = spoilt.positions = spoilt.velocities = false;
  spoilt.outliers = 0.1;
  std::uint32_t refused = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    MeasuredKeyframes good = truth.measure(seed);
    MeasuredKeyframes bad = spoilt.measure(seed);
    // The same noise where the height is no outlier.
    for (std::size_t i = 0; i < good.size(); ++i) {
      if (std::fabs(bad[i].height_m / bad[i].ground_distance / truth.metres_per_unit - 1) < 0.03) bad[i] = good[i];
    }
    const StripFrame a = estimate_strip_frame(good), b = estimate_strip_frame(bad);
    EXPECT_NEAR(b.metres_per_unit / a.metres_per_unit, 1, 0.001) << "seed " << seed;
    EXPECT_LT(spoilt.tilt_error(b), 0.0025) << "seed " << seed;
    refused += b.heights.refused;
  }
  EXPECT_GT(refused, 20U);
}

TEST(StripFrameTest, AWrongUnitIsOutvotedAndOfTwoThatContradictNoneIsBelieved) {
  const auto in_feet = [](MeasuredKeyframes list) {
    for (MeasuredKeyframe& k : list) k.height_m /= metre_per_foot;
    return list;
  };
  TrueStrip truth;
  StripFrame frame = estimate_strip_frame(in_feet(truth.measure(9)));
  EXPECT_EQ(frame.verdict, StripFrameVerdict::scales_contradict);
  EXPECT_LT(truth.scale_error(frame), 0.01) << "by positions and velocities";
  EXPECT_EQ(frame.heights.used, 0U);
  EXPECT_EQ(frame.heights.refused, 30U);

  truth.velocities = false;
  frame = estimate_strip_frame(in_feet(truth.measure(9)));
  EXPECT_EQ(frame.verdict, StripFrameVerdict::scales_contradict);
  EXPECT_EQ(frame.scale_sigma, 0) << "nobody knows which of the two is right";
  EXPECT_EQ(frame.metres_per_unit, 1);
}

TEST(StripFrameTest, PositionsThatContradictGiveNoPlace) {
  TrueStrip truth;
  MeasuredKeyframes list = truth.measure(9);
  // As on a body of half the size.
  for (MeasuredKeyframe& k : list) {
    for (double& metres : k.place_m) metres *= 0.5;
  }
  const StripFrame frame = estimate_strip_frame(list);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::scales_contradict);
  EXPECT_LT(truth.scale_error(frame), 0.003) << "by heights and velocities";
  EXPECT_EQ(frame.positions.used, 0U);
  EXPECT_EQ(frame.horizontal_sigma_m, 0);
}

TEST(StripFrameTest, ACompassThatIsOffIsToldAndTheTrackIsBelieved) {
  TrueStrip truth{.position_noise = 0.5};
  MeasuredKeyframes list = truth.measure(10);
  for (MeasuredKeyframe& k : list) {
    RigidTransform reported;
    reported.rotation = rotation_from_quaternion(k.q_cam_from_level) * rotation_from_vector(Vec3(0, 0, 0.3));
    const Pose attitude = pose_from(reported);
    for (int a = 0; a < 4; ++a) k.q_cam_from_level[a] = attitude.q_cam_from_world[a];
  }
  const StripFrame frame = estimate_strip_frame(list);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::headings_contradict);
  EXPECT_LT(truth.heading_error(frame), 0.005);
  EXPECT_LT(truth.tilt_error(frame), 0.0017);
}

TEST(StripFrameTest, StatedErrorsAreHonest) {
  TrueStrip heights_only{.positions = false, .velocities = false};
  TrueStrip positions_only{.heights = false, .attitudes = false, .velocities = false};
  positions_only.level_from_strip = rotation_from_vector(Vec3(0, 0, 1));
  struct Kind {
    const char* name;
    std::function<double(const StripFrame&)> error, sigma;
    const TrueStrip* strip;
  };
  const Kind kinds[] = {
      {"scale by heights", [&](const StripFrame& f) { return heights_only.scale_error(f); },
       [](const StripFrame& f) { return f.scale_sigma; }, &heights_only},
      {"scale by positions", [&](const StripFrame& f) { return positions_only.scale_error(f); },
       [](const StripFrame& f) { return f.scale_sigma; }, &positions_only},
      {"heading by positions", [&](const StripFrame& f) { return positions_only.heading_error(f); },
       [](const StripFrame& f) { return f.heading_sigma_rad; }, &positions_only},
      {"one axis of the tilt",
       [&](const StripFrame& f) {
         return std::fabs((f.level_from_strip * heights_only.level_from_strip.transpose())(0, 2));
       },
       [](const StripFrame& f) { return f.tilt_sigma_rad; }, &heights_only},
      {"one axis of the place",
       [&](const StripFrame& f) { return std::fabs(f.origin_m.y() - positions_only.origin_m.y()); },
       [](const StripFrame& f) { return f.horizontal_sigma_m; }, &positions_only},
  };
  for (const Kind& kind : kinds) {
    constexpr int trials = 400;
    int within_one = 0, within_two = 0;
    for (int seed = 1; seed <= trials; ++seed) {
      const StripFrame frame = kind.strip->estimate(static_cast<std::uint64_t>(seed) + 1000);
      within_one += kind.error(frame) < kind.sigma(frame) ? 1 : 0;
      within_two += kind.error(frame) < 2 * kind.sigma(frame) ? 1 : 0;
    }
    EXPECT_GT(within_one, trials * 6 / 10) << kind.name;
    EXPECT_LT(within_one, trials * 8 / 10) << kind.name;
    EXPECT_GT(within_two, trials * 92 / 100) << kind.name;
  }
}

TEST(StripFrameTest, HeightsWithoutAnAttitudeStateWhatACameraThatDoesNotQuiteLookDownMeans) {
  TrueStrip truth{.positions = false, .velocities = false};
  const double sure = truth.estimate(3).scale_sigma;
  truth.attitudes = false;
  MeasuredKeyframes list = truth.measure(3);
  // The first camera, whose axis is the strip's z, is 0.1 rad off: it sees level ground farther away along that axis.
  for (MeasuredKeyframe& k : list) k.ground_distance /= det_cos(0.1);
  const StripFrame frame = estimate_strip_frame(list);
  EXPECT_LT(sure, 0.001);
  EXPECT_GT(truth.scale_error(frame), 4 * sure);
  EXPECT_LT(truth.scale_error(frame), 1.2 * frame.scale_sigma);
  EXPECT_LT(frame.scale_sigma, 0.006);
}

TEST(StripFrameTest, ALongStripIsThinnedOutEvenly) {
  MeasuredKeyframes list;
  for (std::int64_t i = 1; i <= 10'000; ++i) {
    MeasuredKeyframe k{.keyframe_id = i};
    add_thinned(k, list);
  }
  ASSERT_GE(list.size(), max_values / 2);
  EXPECT_EQ(list[0].keyframe_id, 1);
  EXPECT_EQ(list.back().keyframe_id, 10'000);
  for (std::size_t i = 1; i < list.size(); ++i) EXPECT_GT(list[i].keyframe_id, list[i - 1].keyframe_id);
}

/// Positions only, of a camera that looks 40 degrees off the ground straight below: the z axis of the strip is its
/// axis.
struct ObliqueTrack {
  Mat3 level_from_strip = rotation_from_vector(Vec3(0, 0, 0.5)) * rotation_from_vector(Vec3(0, 0.7, 0));
  double metres_per_unit = 3, noise_m = 1;
  bool survey = false;

  [[nodiscard]] MeasuredKeyframes measure(std::uint64_t seed) const {
    Rng rng(seed);
    MeasuredKeyframes list;
    for (std::size_t i = 0; i < 40; ++i) {
      MeasuredKeyframe k{.time_ns = static_cast<TimeNs>(i) * 10 * ns_per_s};
      const std::size_t line = survey ? i / 10 : 0, at = survey ? (line % 2 == 0 ? i % 10 : 9 - i % 10) : i;
      // Along the strip's x as the level frame sees it, and lines beside it, all at 500 m.
      const Vec3 place = rotation_from_vector(Vec3(0, 0, 0.5)) *
                         Vec3(30 * static_cast<double>(at), 80 * static_cast<double>(line), 500);
      const Vec3 centre = level_from_strip.transpose() * place / metres_per_unit;
      for (int a = 0; a < 3; ++a) {
        k.centre[a] = centre[a];
        k.place_m[a] = place[a] + noise_m * normal(rng);
      }
      k.horizontal_sigma_m = k.vertical_sigma_m = noise_m;
      add_thinned(k, list);
    }
    return list;
  }
  [[nodiscard]] double up_error(const StripFrame& frame) const {
    return det_acos(std::min(1.0, frame.level_from_strip.row(2).dot(level_from_strip.row(2))));
  }
};

TEST(StripFrameTest, PositionsOverAnObliqueCameraKeepScaleAndLevelOfTheTrack) {
  ObliqueTrack truth;
  const MeasuredKeyframes straight = truth.measure(1);
  const StripFrame along = estimate_strip_frame(straight);
  EXPECT_NEAR(along.metres_per_unit / truth.metres_per_unit, 1, 0.01) << "31 % where the strip's z axis counts as up";
  const Vec3 way =
      along.metres_per_unit * (along.level_from_strip * (Vec3(straight[39].centre) - Vec3(straight[0].centre)));
  EXPECT_NEAR(way.z(), 0, 5) << "a level track of 1170 m stays level";
  EXPECT_EQ(along.tilt_sigma_rad, 0) << "the roll about a straight track is open";
  truth.survey = true;
  const StripFrame survey = estimate_strip_frame(truth.measure(2));
  EXPECT_NEAR(survey.metres_per_unit / truth.metres_per_unit, 1, 0.01);
  EXPECT_GT(survey.tilt_sigma_rad, 0);
  EXPECT_LT(truth.up_error(survey), 0.02) << "lines beside each other say what is up";
  EXPECT_LT(truth.up_error(survey), 6 * survey.tilt_sigma_rad);
  // A camera that looks aside: the track does not see its roll, the lines do.
  truth.level_from_strip = rotation_from_vector(Vec3(0, 0, 0.5)) * rotation_from_vector(Vec3(0.7, 0, 0));
  EXPECT_LT(truth.up_error(estimate_strip_frame(truth.measure(3))), 0.02);
}

TEST(StripFrameTest, AFewWrongPositionsDoNotTiltTheTrack) {
  ObliqueTrack truth{.survey = true};
  MeasuredKeyframes list = truth.measure(4);
  for (const std::size_t wrong : {5U, 17U, 33U}) list[wrong].place_m[2] += 400;
  EXPECT_LT(truth.up_error(estimate_strip_frame(list)), 0.02);
}

TEST(StripFrameTest, ScatterThatNobodyStatedIsNotAveragedAway) {
  TrueStrip truth;
  MeasuredKeyframes signs = truth.measure(10);
  // Every second altitude has the wrong sign: 97 m apart, with 2 m stated.
  for (std::size_t i = 0; i < signs.size(); i += 2) signs[i].place_m[2] -= 97;
  EXPECT_GT(estimate_strip_frame(signs).vertical_sigma_m, 40);
  EXPECT_LT(estimate_strip_frame(signs).horizontal_sigma_m, 3) << "the other components stay as sure as they were";
  // A third of them: these are left out, and counted.
  MeasuredKeyframes third = truth.measure(13);
  for (std::size_t i = 0; i < third.size(); i += 3) third[i].place_m[2] -= 97;
  EXPECT_EQ(estimate_strip_frame(third).positions.refused, 10U);
  MeasuredKeyframes groups = truth.measure(11);
  for (std::size_t i = 0; i < groups.size() / 2; ++i) groups[i].place_m[2] += 60;
  EXPECT_GT(estimate_strip_frame(groups).vertical_sigma_m, 20);
  EXPECT_LT(estimate_strip_frame(truth.measure(12)).vertical_sigma_m, 3);
}

/// As photographs have it whose camera is taken to look straight down, to 6 degrees in each image.
void look_down(MeasuredKeyframes& list) {
  for (MeasuredKeyframe& k : list) {
    const double down[4] = {0, 1, 0, 0};
    for (int a = 0; a < 4; ++a) k.q_cam_from_level[a] = down[a];
    k.tilt_sigma_rad = 0.1;
  }
}

TEST(StripFrameTest, ACameraThatIsTakenToLookDownGivesWayToThePositions) {
  ObliqueTrack truth;
  MeasuredKeyframes list = truth.measure(5);
  // The strip's axes are those of its first camera.
  for (MeasuredKeyframe& k : list) {
    const double first[4] = {0, 1, 0, 0};
    for (int a = 0; a < 4; ++a) k.q_cam_from_strip[a] = first[a];
  }
  look_down(list);
  const StripFrame along = estimate_strip_frame(list);
  EXPECT_EQ(along.verdict, StripFrameVerdict::attitudes_contradict);
  EXPECT_EQ(along.attitudes.used, 0U);
  EXPECT_EQ(along.attitudes.refused, 40U);
  EXPECT_EQ(along.tilt_sigma_rad, 0) << "the roll about a straight track is open";
  EXPECT_NEAR(along.metres_per_unit / truth.metres_per_unit, 1, 0.01);
  truth.survey = true;
  MeasuredKeyframes lines = truth.measure(6);
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (int a = 0; a < 4; ++a) lines[i].q_cam_from_strip[a] = list[i].q_cam_from_strip[a];
  look_down(lines);
  const StripFrame survey = estimate_strip_frame(lines);
  EXPECT_EQ(survey.verdict, StripFrameVerdict::attitudes_contradict);
  EXPECT_GT(survey.tilt_sigma_rad, 0);
  EXPECT_LT(truth.up_error(survey), 0.02);
}

TEST(StripFrameTest, AnAttitudeThatThePositionsConfirmStays) {
  TrueStrip truth;
  for (std::uint64_t seed = 20; seed < 60; ++seed) {
    const StripFrame frame = truth.estimate(seed);
    EXPECT_EQ(frame.verdict, StripFrameVerdict::ok) << seed;
    EXPECT_GE(frame.attitudes.used, 28U);
  }
}

TEST(StripFrameTest, AReceiverThatHasFrozenIsTold) {
  TrueStrip truth;
  MeasuredKeyframes frozen = truth.measure(14);
  for (MeasuredKeyframe& k : frozen) std::copy_n(frozen[0].place_m, 3, k.place_m);
  const StripFrame frame = estimate_strip_frame(frozen);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::positions_frozen);
  EXPECT_EQ(frame.positions.used, 0U);
  EXPECT_EQ(frame.positions.refused, 30U);
  EXPECT_EQ(frame.horizontal_sigma_m, 0) << "no place";
  EXPECT_LT(truth.scale_error(frame), 0.003) << "the heights say it";
  // Positions alone: nothing is measured, which is told as well.
  truth.heights = truth.attitudes = truth.velocities = false;
  MeasuredKeyframes alone = truth.measure(15);
  for (MeasuredKeyframe& k : alone) std::copy_n(alone[0].place_m, 3, k.place_m);
  EXPECT_EQ(estimate_strip_frame(alone).verdict, StripFrameVerdict::positions_frozen);
  EXPECT_EQ(estimate_strip_frame(alone).scale_sigma, 0);
  // A few that come twice are no frozen receiver.
  MeasuredKeyframes twice = truth.measure(16);
  for (const std::size_t i : {4U, 9U, 17U}) std::copy_n(twice[i - 1].place_m, 3, twice[i].place_m);
  EXPECT_EQ(estimate_strip_frame(twice).verdict, StripFrameVerdict::ok);
  // Nor is a hover, whose images do not move.
  MeasuredKeyframes hover = truth.measure(17);
  for (std::size_t i = 0; i < hover.size(); ++i) {
    std::copy_n(hover[0].place_m, 3, hover[i].place_m);
    std::copy_n(hover[0].centre, 3, hover[i].centre);
    hover[i].centre[0] += 1e-4 * static_cast<double>(i % 2);
  }
  EXPECT_NE(estimate_strip_frame(hover).verdict, StripFrameVerdict::positions_frozen);
}

}  // namespace
}  // namespace ilp::navigation
