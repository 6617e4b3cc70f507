// Patterns and passes of a flight against the geometry that defines them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/world/flight.hpp"
#include "sim/world/ground_track.hpp"
#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double nanosecond = 1e-9;

/// A line over a pattern, at 2 m/s.
FlightParams line_over(const char* pattern) {
  FlightParams params{.kind = "line", .frames = 400, .drift_m_s = 2, .pattern = pattern};
  return params;
}

const std::vector<std::string>& patterns() {
  static const std::vector<std::string> names = {"straight",  "lawn-mower",   "circle",
                                                 "rectangle", "figure-eight", "rosette"};
  return names;
}

CameraMotion after_way(const Trajectory& trajectory, double way_m) {
  return trajectory.motion(std::llround(way_m / 2 / nanosecond));
}

/// Direction in which the camera moves.
double course_of(const CameraMotion& motion) {
  return std::atan2(motion.velocity_m_s.y(), motion.velocity_m_s.x());
}

/// Direction of the image's x axis.
double heading_of(const CameraMotion& motion) {
  return std::atan2(motion.state.rotation(0, 1), motion.state.rotation(0, 0));
}

double angle_between(double a, double b) {
  return std::fabs(std::remainder(a - b, 2 * pi));
}

struct Extent {
  Vec2 low = Vec2::Constant(1e9), high = Vec2::Constant(-1e9);
};

Extent extent_of(const Trajectory& trajectory, double way_m) {
  Extent extent;
  for (double way = 0; way <= way_m; way += 0.05) {
    const Vec2 place = after_way(trajectory, way).state.centre.head<2>();
    extent.low = extent.low.cwiseMin(place);
    extent.high = extent.high.cwiseMax(place);
  }
  return extent;
}

TEST(Patterns, AreFlownAtTheSpeedOfTheDriftAndTurnNoFasterThanTheirRadiusAllows) {
  for (const std::string& pattern : patterns()) {
    FlightParams params = line_over(pattern.c_str());
    params.pattern_length_m = 180;
    params.pattern_width_m = 80;
    params.pattern_turn_radius_m = 20;
    params.drift_heading_rad = 0.7;
    const double radius = pattern == "circle" ? 90 : pattern == "figure-eight" ? 40 : 20;
    const Trajectory trajectory(params);
    double turned_most = 0;
    constexpr std::int64_t step = 97'000'000;
    constexpr double step_s = 0.097;
    for (std::int64_t t = step; t < trajectory.end_ns(); t += step) {
      const CameraMotion before = trajectory.motion(t - step), now = trajectory.motion(t);
      ASSERT_NEAR(now.velocity_m_s.norm(), 2, 1e-9) << pattern;
      ASSERT_NEAR((now.state.centre - before.state.centre - step_s * before.velocity_m_s).norm(), 0,
                  0.6 * 4 / radius * step_s * step_s)
          << pattern << " at " << t;
      const double turn = angle_between(course_of(now), course_of(before));
      ASSERT_LE(turn, 2 / radius * step_s + 1e-9) << pattern << " at " << t;
      ASSERT_LE(now.turn_rad_s.norm(), 2 / radius + 1e-9);
      ASSERT_NEAR(angle_between(heading_of(now), course_of(now)), 0, 1e-6) << "the camera turns with the track";
      turned_most = std::max(turned_most, now.turn_rad_s.norm());
    }
    EXPECT_NEAR(turned_most, pattern == "straight" ? 0 : 2 / radius, 1e-9) << pattern;
  }
}

TEST(Patterns, BeginAtTheStartInTheDirectionOfTheDrift) {
  for (const std::string& pattern : patterns()) {
    FlightParams params = line_over(pattern.c_str());
    params.drift_heading_rad = -2;
    params.start_x_m = 70;
    params.start_y_m = -30;
    const CameraMotion first = Trajectory(params).motion(0);
    EXPECT_NEAR((first.state.centre - Vec3(70, -30, 100)).norm(), 0, 1e-9) << pattern;
    EXPECT_NEAR(course_of(first), -2, 1e-9) << pattern;
    EXPECT_NEAR(heading_of(first), -2, 1e-9) << pattern;
  }
}

TEST(Patterns, LegsOfALawnMowerAreParallelAndOverlapAsStated) {
  // Turns of two quarters of a circle, and turns that must swing out because the legs are close.
  for (const auto& [side_overlap, radius] : {std::pair{0.2, 20.0}, std::pair{0.6, 25.0}}) {
    FlightParams params = line_over("lawn-mower");
    params.pattern_length_m = 150;
    params.pattern_turn_radius_m = radius;
    params.side_overlap = side_overlap;
    const Trajectory trajectory(params);
    // At 100 m an image of 480 rows and 550 px focal length shows 87.27 m.
    const double spacing = (1 - side_overlap) * 100 * 480 / 550.0;
    const double bulge = std::acos((1 + spacing / (2 * radius)) / 2);
    const double turn = spacing >= 2 * radius ? pi * radius + spacing - 2 * radius : (pi + 4 * bulge) * radius;
    for (int leg = 0; leg < 3; ++leg) {
      for (const double along : {1.0, 75.0, 149.0}) {
        const CameraMotion motion = after_way(trajectory, leg * (150 + turn) + along);
        const bool back = leg % 2 == 1;
        EXPECT_NEAR(motion.state.centre.x(), back ? 150 - along : along, 1e-6) << leg;
        EXPECT_NEAR(motion.state.centre.y(), leg * spacing, 1e-6) << leg;
        EXPECT_NEAR(angle_between(course_of(motion), back ? pi : 0), 0, 1e-9);
      }
    }
  }
}

TEST(Patterns, ClosedLoopsCloseAndHaveTheirStatedSize) {
  struct Loop {
    const char* pattern;
    double length, width, radius;  // of the pattern
    double way;                    // around it
    Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  };
  const double tangent = std::sqrt(100.0 * 100 - 50 * 50);
  const std::vector<Loop> loops = {
      {"circle", 200, 50, 9, 200 * pi, {-100, 0}, {100, 200}},
      {"rectangle", 240, 100, 30, 2 * (180 + 40) + 60 * pi, {-120, 0}, {120, 100}},
      // Centres 100 m from the crossing, radius 50 m: tangents at 30 degrees to the axis, arcs of 240 degrees.
      {"figure-eight", 300, 100, 9, 4 * tangent + 2 * 50 * (4 * pi / 3)},
  };
  for (const Loop& loop : loops) {
    FlightParams params = line_over(loop.pattern);
    params.pattern_length_m = loop.length;
    params.pattern_width_m = loop.width;
    params.pattern_turn_radius_m = loop.radius;
    params.frames = 900;
    const Trajectory trajectory(params);
    for (const double way : {0.0, 33.0, 0.6 * loop.way}) {
      const CameraMotion first = after_way(trajectory, way);
      for (const int rounds : {1, 3}) {
        const CameraMotion again = after_way(trajectory, way + rounds * loop.way);
        EXPECT_NEAR((again.state.centre - first.state.centre).norm(), 0, 1e-6) << loop.pattern << " at " << way;
        EXPECT_NEAR(angle_between(course_of(again), course_of(first)), 0, 1e-7) << loop.pattern;
        EXPECT_NEAR((again.state.rotation - first.state.rotation).norm(), 0, 1e-7) << loop.pattern;
      }
    }
    if (loop.low == loop.high) continue;
    const Extent extent = extent_of(trajectory, loop.way);
    EXPECT_NEAR((extent.low - loop.low).norm(), 0, 0.01) << loop.pattern;
    EXPECT_NEAR((extent.high - loop.high).norm(), 0, 0.01) << loop.pattern;
  }
}

TEST(Patterns, FigureEightCrossesItselfInTheMiddleOfTwoLobes) {
  FlightParams params = line_over("figure-eight");
  params.pattern_length_m = 300;
  params.pattern_width_m = 100;
  // The tangents make 30 degrees with the axis, which then lies along x.
  params.drift_heading_rad = -pi / 6;
  const Trajectory trajectory(params);
  const double half_round = 2 * std::sqrt(7500.0) + 50 * 4 * pi / 3;
  const CameraMotion crossing = after_way(trajectory, half_round);
  EXPECT_NEAR(crossing.state.centre.head<2>().norm(), 0, 1e-6);
  EXPECT_NEAR(angle_between(course_of(crossing), course_of(trajectory.motion(0))), 2 * pi / 3, 1e-7)
      << "another direction";
  const Extent extent = extent_of(trajectory, 2 * half_round);
  EXPECT_NEAR((extent.low - Vec2(-150, -50)).norm(), 0, 0.01);
  EXPECT_NEAR((extent.high - Vec2(150, 50)).norm(), 0, 0.01);
}

TEST(Patterns, EveryLineOfARosetteLeadsThroughTheStartInAnotherDirection) {
  FlightParams params = line_over("rosette");
  params.pattern_length_m = 60;
  params.pattern_turn_radius_m = 12;
  params.frames = 800;
  const Trajectory trajectory(params);
  const double turn = pi + 2 * std::atan(12.0 / 30);
  const double round = 60 + 12 * turn;
  for (int k = 0; k < 15; ++k) {
    const CameraMotion motion = after_way(trajectory, k * round);
    EXPECT_NEAR(motion.state.centre.head<2>().norm(), 0, 1e-6) << k;
    EXPECT_NEAR(angle_between(course_of(motion), k * turn), 0, 1e-7) << k;
  }
  const Extent extent = extent_of(trajectory, 15 * round);
  const double reach = std::sqrt(30.0 * 30 + 12 * 12) + 12;
  EXPECT_LT(std::max({-extent.low.x(), -extent.low.y(), extent.high.x(), extent.high.y()}), reach + 1e-9);
}

TEST(Patterns, CameraKeepsItsHeadingIfItDoesNotTurnWithTheTrack) {
  FlightParams params = line_over("circle");
  params.turn_with_track = false;
  params.drift_heading_rad = 0.3;
  for (const CameraState& state : fly(params))
    EXPECT_NEAR(std::atan2(state.rotation(0, 1), state.rotation(0, 0)), 0.3, 1e-12);
}

TEST(Patterns, BalloonFollowsThePatternWithItsMeanderAndItsSwing) {
  FlightParams params = line_over("figure-eight");
  params.kind = "balloon";
  params.gust_m_s = 0;
  const std::vector<CameraState> balloon = fly(params);
  params.kind = "line";
  const std::vector<CameraState> line = fly(params);
  double farthest = 0, tilted_most = 0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    farthest = std::max(farthest, (balloon[k].centre - line[k].centre).head<2>().norm());
    tilted_most = std::max(tilted_most, std::acos(-balloon[k].rotation(2, 2)));
  }
  EXPECT_GT(farthest, params.meander_m / 2);
  EXPECT_LT(farthest, 2 * params.meander_m);
  EXPECT_GT(tilted_most, 0.01);
  EXPECT_LT(tilted_most, 0.15);
}

FlightParams two_passes() {
  FlightParams params = line_over("straight");
  params.frames = 41;
  params.passes = 2;
  params.pass_pause_s = 30;
  params.pass_altitude = 0.7;
  params.pass_heading_rad = 0.4;
  params.pass_yaw_rad = 0.2;
  return params;
}

TEST(Passes, FlyTheSamePatternTurnedAboutItsMiddleAtAnotherHeightWithAPauseBetween) {
  const FlightParams params = two_passes();
  const std::vector<CameraState> states = fly(params);
  ASSERT_EQ(states.size(), 41U);
  // 21 frames, then 20: a pass takes 42 s and 84 m.
  const Vec3 middle(42, 0, 0);
  for (int k = 0; k < 41; ++k) {
    const CameraState& state = states[static_cast<std::size_t>(k)];
    const bool second = k >= 21;
    EXPECT_EQ(state.time_ns, (2LL * k + (second ? 30 : 0)) * 1'000'000'000);
    const double way = 4.0 * (second ? k - 21 : k);
    const Vec3 first_pass(way, 0, 0);
    const Mat3 turn = Eigen::AngleAxisd(second ? 0.4 : 0.0, Vec3::UnitZ()).toRotationMatrix();
    const Vec3 expected = middle + turn * (first_pass - middle) + Vec3(0, 0, second ? 70 : 100);
    EXPECT_NEAR((state.centre - expected).norm(), 0, 1e-9) << k;
    EXPECT_NEAR(std::atan2(state.rotation(0, 1), state.rotation(0, 0)), second ? 0.6 : 0, 1e-12) << k;
  }
}

TEST(Passes, ChangeInTheMiddleOfThePause) {
  const Trajectory trajectory(two_passes());
  EXPECT_EQ(trajectory.pass_at(0), 0);
  EXPECT_EQ(trajectory.pass_at(56'900'000'000), 0);
  EXPECT_EQ(trajectory.pass_at(57'100'000'000), 1);
  EXPECT_EQ(trajectory.pass_at(trajectory.end_ns()), 1);
}

TEST(Passes, MotionIsContinuousAndTheDerivativeOfTheStateAlsoInThePause) {
  for (const char* kind : {"line", "balloon", "hover"}) {
    FlightParams params = two_passes();
    params.kind = kind;
    if (params.kind != "hover") params.pattern = "circle";
    const Trajectory trajectory(params);
    constexpr std::int64_t dt = 1'000'000;
    for (std::int64_t t = dt; t + dt < trajectory.end_ns(); t += 77'777'777) {
      const CameraMotion motion = trajectory.motion(t);
      const CameraState before = trajectory.at(t - dt), after = trajectory.at(t + dt);
      ASSERT_NEAR((motion.velocity_m_s - (after.centre - before.centre) / 2e-3).norm(), 0, 1e-4) << kind << " at " << t;
      const Mat3 rate = (after.rotation - before.rotation) / 2e-3 * motion.state.rotation.transpose();
      ASSERT_NEAR((motion.turn_rad_s - Vec3(rate(2, 1), rate(0, 2), rate(1, 0))).norm(), 0, 1e-5) << kind << " " << t;
    }
  }
}

TEST(Passes, TheWayFromOnePassToTheNextDoesNotSwingTheGondola) {
  FlightParams params = two_passes();
  params.kind = "balloon";
  params.pass_pause_s = 1;  // 84 m back in a second
  EXPECT_NO_THROW((void)fly(params));
}

TEST(Patterns, ParametersThatContradictEachOtherAreNamed) {
  const std::pair<FlightParams, const char*> contradictions[] = {
      {{.pattern = "zigzag"},
       "[flight] pattern = zigzag: expected straight, lawn-mower, circle, rectangle, figure-eight or rosette"},
      {{.kind = "hover", .pattern = "circle"}, "[flight] pattern = circle: expected straight for a hover"},
      {{.pattern = "rectangle", .pattern_turn_radius_m = 61},
       "[flight] pattern_turn_radius_m = 61: expected at most 60"},
      {{.pattern = "figure-eight", .pattern_length_m = 240}, "[flight] pattern_length_m = 240: expected more than 240"},
      {{.pattern = "circle", .revisit = 0.5}, "[flight] revisit = 0.5: expected 0 for a pattern or several passes"},
      {{.kind = "descent", .passes = 2}, "[flight] passes = 2: expected 1 for a descent"},
      {{.passes = 0}, "[flight] passes = 0"},
      {{.side_overlap = 1}, "[flight] side_overlap = 1"},
      // Once around in the period of the pendulum.
      {{.pattern = "circle", .pattern_length_m = 10}, "pattern: the gondola would swing"},
  };
  for (const auto& [params, named] : contradictions) {
    const std::string said = test::error_of<std::invalid_argument>([&p = params] { (void)fly(p); });
    EXPECT_TRUE(test::says(said, named)) << named;
  }
}

TEST(Patterns, TheSmallestAndTheLargestLengthsAreFlown) {
  for (const std::string& pattern : patterns()) {
    for (const double size : {0.02, 1e6}) {
      FlightParams params = line_over(pattern.c_str());
      params.pattern_length_m = size;
      params.pattern_width_m = 0.4 * size;
      params.pattern_turn_radius_m = 0.1 * size;
      params.frames = 9999;
      const std::vector<CameraState> states = fly(params);
      EXPECT_TRUE(states.back().centre.allFinite()) << pattern;
      EXPECT_LT(states.back().centre.norm(), 2 * 2 * 9999 + 1000.0) << pattern;
    }
  }
}

}  // namespace
}  // namespace ilp::world
