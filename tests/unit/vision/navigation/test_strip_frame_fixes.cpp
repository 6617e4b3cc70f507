// The similarity of a strip from fixes on a map, against similarities that are known.
#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"
#include "tests/unit/vision/navigation/normal_numbers.hpp"

namespace ilp::navigation {
namespace {

/// A strip over level ground with a known similarity. Its fixes have the errors that they state: the camera's place is
/// known worse than that of its ground.
struct FixedStrip {
  double metres_per_unit = 2.5;
  Mat3 level_from_strip = rotation_from_vector(Vec3(0, 0, 0.8)) * rotation_from_vector(Vec3(0.03, -0.02, 0));
  Vec3 origin_m{520, -340, 900};
  int keyframes = 20;
  int fix_every = 1;
  double ground_noise = 0.3, attitude_noise = 0.004, depth_noise = 0.01, distance_noise = 0.3;
  double outliers = 0;   ///< share of fixes that are 30 m off
  double positions = 0;  ///< error of the vehicle's positions, m; 0: none
  Vec3 positions_off_m = Vec3::Zero();
  double map_sigma_m = 0;

  [[nodiscard]] MeasuredKeyframes measure(std::uint64_t seed) const {
    Rng rng(seed);
    MeasuredKeyframes list;
    for (int i = 0; i < keyframes; ++i) {
      MeasuredKeyframe k{.keyframe_id = i + 1, .time_ns = i * 10 * ns_per_s};
      const Vec3 place = origin_m + Vec3(24.0 * i, 32.0 * i, 3 * det_sin(0.4 * i));
      const double ground_z = origin_m.z() - 100;
      const Vec3 centre = level_from_strip.transpose() * (place - origin_m) / metres_per_unit;
      const Mat3 cam_from_level =
          Mat3(Vec3(1, -1, -1).asDiagonal()) * rotation_from_vector(0.05 * Vec3(normal(rng), normal(rng), 0));
      copy(centre, k.centre);
      quaternion_from_rotation(cam_from_level * level_from_strip, k.q_cam_from_strip);
      const Vec3 axis = cam_from_level.row(2);
      const double distance = (place.z() - ground_z) / -axis.z();
      const bool wrong = rng.uniform() < outliers;
      if (i % fix_every == 0) {
        const Vec3 error(normal(rng), normal(rng), normal(rng));
        copy(place + distance * axis + ground_noise * error + (wrong ? Vec3(25, -20, 0) : Vec3(0, 0, 0)),
             k.fix.ground_m);
        for (double& sigma : k.fix.ground_sigma_m) sigma = ground_noise;
        const Vec3 turn(normal(rng), normal(rng), normal(rng));
        quaternion_from_rotation(cam_from_level * rotation_from_vector(attitude_noise * turn), k.fix.q_cam_from_level);
        k.fix.tilt_sigma_rad = k.fix.heading_sigma_rad = attitude_noise;
        k.fix.distance_m = distance + distance_noise * normal(rng);
        k.fix.distance_sigma_m = distance_noise;
        k.fix.depth = distance / metres_per_unit * (1 + depth_noise * normal(rng));
        k.fix.depth_sigma = depth_noise * k.fix.depth;
        k.fix.map_sigma_m = map_sigma_m;
      }
      if (positions > 0) {
        for (int a = 0; a < 3; ++a) k.place_m[a] = place[a] + positions * normal(rng) + positions_off_m[a];
        k.horizontal_sigma_m = k.vertical_sigma_m = positions;
      }
      add_thinned(k, list);
    }
    return list;
  }
  [[nodiscard]] StripFrame estimate(std::uint64_t seed) const { return estimate_strip_frame(measure(seed)); }
  static void copy(const Vec3& from, double (&to)[3]) {
    for (int a = 0; a < 3; ++a) to[a] = from[a];
  }

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
  [[nodiscard]] double place_error(const FixedPlace& reported, const MeasuredKeyframe& k) const {
    const Vec3 error = reported.place_m - (origin_m + metres_per_unit * (level_from_strip * centre_of(k)));
    return std::sqrt(error.x() * error.x() + error.y() * error.y());
  }
  [[nodiscard]] double place_error(const StripFrame& frame, const MeasuredKeyframe& k) const {
    return place_error(place_by_fixes(frame, centre_of(k)), k);
  }
  [[nodiscard]] static Vec3 centre_of(const MeasuredKeyframe& k) { return vector_of(k.centre); }
};

TEST(StripFrameFixes, GiveScaleLevelHeadingAndPlace) {
  const FixedStrip truth;
  const StripFrame frame = truth.estimate(1);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::ok);
  EXPECT_LT(truth.scale_error(frame), 0.001);
  EXPECT_LT(truth.tilt_error(frame), 0.003);
  EXPECT_LT(truth.heading_error(frame), 0.001);
  EXPECT_LT((frame.origin_m - truth.origin_m).norm(), 2);
  EXPECT_GE(frame.fixes.used, 18U);
}

TEST(StripFrameFixes, OneFixGivesThemAllAndNoneGivesNothing) {
  FixedStrip truth{.fix_every = 100};
  const StripFrame frame = truth.estimate(2);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::ok);
  EXPECT_LT(truth.scale_error(frame), 4 * frame.scale_sigma);
  EXPECT_NEAR(frame.scale_sigma, 0.01, 0.003) << "that of the depth";
  EXPECT_LT(truth.heading_error(frame), 0.02);
  EXPECT_GT(frame.horizontal_sigma_m, 0);
  EXPECT_EQ(frame.fixes.used, 1U);
  truth.keyframes = 0;
  EXPECT_EQ(truth.estimate(3).verdict, StripFrameVerdict::nothing_measured);
}

TEST(StripFrameFixes, WorkWithoutDepth) {
  const FixedStrip truth;
  MeasuredKeyframes list = truth.measure(4);
  for (std::size_t i = 0; i < list.size(); i += 2) list[i].fix.depth = 0;
  const StripFrame frame = estimate_strip_frame(list);
  EXPECT_LT(truth.scale_error(frame), 0.002);
  EXPECT_LT(truth.place_error(frame, list[10]), 1);
  EXPECT_GE(frame.fixes.used, 18U);
}

TEST(StripFrameFixes, WrongOnesAreLeftOut) {
  FixedStrip truth{.outliers = 0.2};
  int worse = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const MeasuredKeyframes list = truth.measure(seed);
    const StripFrame frame = estimate_strip_frame(list);
    worse += truth.place_error(frame, list[10]) > 1 ? 1 : 0;
  }
  EXPECT_LE(worse, 1);
}

TEST(StripFrameFixes, SigmasAreHonest) {
  FixedStrip truth;
  double scale = 0, tilt = 0, heading = 0, origin = 0, place = 0;
  constexpr int runs = 200;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    truth.fix_every = 1 + static_cast<int>(seed % 5);
    const MeasuredKeyframes list = truth.measure(seed);
    const StripFrame frame = estimate_strip_frame(list);
    const auto add = [](double error, double sigma, double& sum) { sum += error * error / (sigma * sigma); };
    add(truth.scale_error(frame), frame.scale_sigma, scale);
    add(truth.tilt_error(frame), frame.tilt_sigma_rad, tilt);
    add(truth.heading_error(frame), frame.heading_sigma_rad, heading);
    add((frame.origin_m - truth.origin_m).head<2>().norm(), frame.horizontal_sigma_m, origin);
    // The last keyframe, as the next one would be predicted.
    const FixedPlace last = place_by_fixes(frame, FixedStrip::centre_of(list.back()));
    add(truth.place_error(last, list.back()), last.sigma_m[0], place);
  }
  // Normalised squares have the mean of their dimensions: 1, 2, 1, 2, 2.
  EXPECT_GT(scale / runs, 0.5);
  EXPECT_LT(scale / runs, 1.6);
  EXPECT_GT(tilt / runs / 2, 0.5);
  EXPECT_LT(tilt / runs / 2, 1.6);
  EXPECT_GT(heading / runs, 0.5);
  EXPECT_LT(heading / runs, 1.6);
  EXPECT_GT(origin / runs / 2, 0.3);
  EXPECT_LT(origin / runs / 2, 1.6);
  EXPECT_GT(place / runs / 2, 0.3);
  EXPECT_LT(place / runs / 2, 1.6);
}

TEST(StripFrameFixes, AgreeWithPositionsOrNeitherCounts) {
  FixedStrip truth{.positions = 2};
  StripFrame frame = truth.estimate(5);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::ok);
  EXPECT_GE(frame.positions.used, 18U);
  EXPECT_GE(frame.fixes.used, 18U);

  truth.positions_off_m = Vec3(60, 0, 0);
  frame = truth.estimate(5);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::fixes_contradict);
  EXPECT_EQ(frame.horizontal_sigma_m, 0);
  EXPECT_EQ(frame.positions.used, 0U);
  EXPECT_EQ(frame.fixes.used, 0U);
  EXPECT_GT(frame.scale_sigma, 0) << "the lengths agree";
  EXPECT_GT(frame.fixed_sigma_m[0], 0) << "the place on the map is known all the same";

  truth.map_sigma_m = 50;
  frame = truth.estimate(5);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::ok) << "the map's own place has such errors";
  EXPECT_NEAR(frame.horizontal_sigma_m, 2 / std::sqrt(20), 0.5) << "positions weigh more then";
}

TEST(StripFrameFixes, HeadingsOfACompassGiveWay) {
  const FixedStrip truth;
  MeasuredKeyframes list = truth.measure(6);
  for (MeasuredKeyframe& k : list) {
    const Mat3 cam_from_level = rotation_from_quaternion(k.q_cam_from_strip) * truth.level_from_strip.transpose();
    quaternion_from_rotation(cam_from_level * rotation_from_vector(Vec3(0, 0, 0.2)), k.q_cam_from_level);
    k.tilt_sigma_rad = k.heading_sigma_rad = 0.005;
  }
  const StripFrame frame = estimate_strip_frame(list);
  EXPECT_EQ(frame.verdict, StripFrameVerdict::headings_contradict);
  EXPECT_LT(truth.heading_error(frame), 0.002);
}

TEST(StripFrameFixes, ALevelSensorThatIsOffGivesWay) {
  const FixedStrip truth;
  MeasuredKeyframes list = truth.measure(7);
  for (MeasuredKeyframe& k : list) {
    const Mat3 cam_from_level = rotation_from_quaternion(k.q_cam_from_strip) * truth.level_from_strip.transpose();
    quaternion_from_rotation(cam_from_level * rotation_from_vector(Vec3(0.05, 0, 0)), k.q_cam_from_level);
    k.tilt_sigma_rad = 0.003;
  }
  const StripFrame frame = estimate_strip_frame(list);
  EXPECT_LT(truth.tilt_error(frame), 0.004);
  EXPECT_EQ(frame.attitudes.used, 0U);
}

TEST(StripFrameFixes, SigmasOfAnAttitudeAreThoseAboutUp) {
  Mat3 covariance = Mat3::Zero();
  covariance(0, 0) = 0.01;
  covariance(2, 2) = 0.09;
  double tilt = 0, heading = 0;
  // The camera looks down: its z axis is down.
  level_sigmas(covariance, Mat3(Vec3(1, -1, -1).asDiagonal()), tilt, heading);
  EXPECT_NEAR(heading, 0.3, 1e-12);
  EXPECT_NEAR(tilt, std::sqrt(0.005), 1e-12);
}

}  // namespace
}  // namespace ilp::navigation
