#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include "sim/world/flight.hpp"
#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

constexpr double pi = 3.14159265358979323846;

// Share of the first footprint on the plane z = 0 that the second camera sees.
double overlap(const CameraModel& camera, const CameraState& first, const CameraState& second) {
  int seen = 0, all = 0;
  for (int v = 4; v < camera.height; v += 8) {
    for (int u = 4; u < camera.width; u += 8) {
      const Vec3 ray = first.rotation.transpose() * Vec3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
      const Vec3 ground = first.centre - first.centre.z() / ray.z() * ray;
      const Vec3 x = second.rotation * (ground - second.centre);
      const double px = camera.fx * x.x() / x.z() + camera.cx, py = camera.fy * x.y() / x.z() + camera.cy;
      ++all;
      seen += px > -0.5 && py > -0.5 && px < camera.width - 0.5 && py < camera.height - 0.5;
    }
  }
  return static_cast<double>(seen) / all;
}

Vec3 optical_axis(const CameraState& state) {
  return state.rotation.row(2);
}

FlightParams of_kind(const char* kind) {
  FlightParams params{.kind = kind};
  return params;
}

/// One flight of each kind, everything on that it can do.
std::vector<FlightParams> all_kinds() {
  std::vector<FlightParams> flights = {of_kind("balloon"), of_kind("line"), of_kind("hover"), of_kind("descent"),
                                       of_kind("descent")};
  flights.back().descent_ratio = 20;
  flights.back().descent_drift = 0.4;
  for (FlightParams& flight : flights) {
    flight.off_nadir_rad = 0.3;
    flight.off_nadir_azimuth_rad = 1;
    flight.drift_heading_rad = 2;
    flight.yaw_rate_rad_s = -0.01;
    flight.descent_m_s = 0.5;
  }
  for (std::size_t k : {0U, 1U}) {
    flights[k].revisit = 0.5;
    flights[k].revisit_offset_m = 20;
    flights[k].revisit_yaw_rad = pi;
  }
  return flights;
}

TEST(Flight, DefaultTrackGivesTheOverlapCheckerSomethingToChoose) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    FlightParams params{.seed = seed};
    const std::vector<CameraState> states = fly(params);
    ASSERT_EQ(states.size(), static_cast<std::size_t>(params.frames));
    std::size_t keyframe = 0;
    int keyframes = 1;
    for (std::size_t k = 1; k < states.size(); ++k) {
      if (overlap(params.camera, states[keyframe], states[k]) > 0.82) continue;
      keyframe = k;
      ++keyframes;
    }
    EXPECT_GE(keyframes, 14) << "seed " << seed;
    EXPECT_LE(keyframes, 30) << "seed " << seed;
  }
}

TEST(Flight, AttitudeIsARotationThatLooksDown) {
  const FlightParams params;
  double tilted_most = 0;
  for (const CameraState& state : fly(params)) {
    EXPECT_NEAR((state.rotation * state.rotation.transpose() - Mat3::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(state.rotation.determinant(), 1, 1e-12);
    tilted_most = std::max(tilted_most, std::acos(-state.rotation(2, 2)));
    EXPECT_GT(state.rotation(0, 0), std::cos(params.yaw_rad) - 0.01) << "the image's x axis points along the drift";
    EXPECT_NEAR(state.centre.z(), params.altitude_m, 0.035 * params.altitude_m);
  }
  EXPECT_GT(tilted_most, 0.7 * params.swing_rad) << "it does swing";
  EXPECT_LT(tilted_most, 3 * params.swing_rad);
}

TEST(Flight, DriftsTheDistanceItIsToldInTheDirectionItIsTold) {
  FlightParams params{.drift_heading_rad = 2, .gust_m_s = 0};
  const std::vector<CameraState> states = fly(params);
  const Vec3 way = states.back().centre - states.front().centre;
  const double wanted = params.drift_m_s * params.interval_s * (params.frames - 1);
  const double slack = 2 * params.meander_m + 2 * params.suspension_m * params.swing_rad;
  EXPECT_NEAR(way.x(), wanted * std::cos(2.0), slack);
  EXPECT_NEAR(way.y(), wanted * std::sin(2.0), slack);
  for (std::size_t k = 0; k < states.size(); ++k) {
    EXPECT_EQ(states[k].time_ns, static_cast<std::int64_t>(k) * 2'000'000'000);
  }
}

TEST(Flight, SameSeedIsTheSameFlightAndAnotherSeedAnother) {
  FlightParams params;
  const std::vector<CameraState> one = fly(params), again = fly(params);
  params.seed = 2;
  const std::vector<CameraState> other = fly(params);
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].centre, again[k].centre);
    EXPECT_EQ(one[k].rotation, again[k].rotation);
  }
  EXPECT_GT((one[10].centre - other[10].centre).norm(), 0.01);
}

TEST(Flight, LineIsStraightAndItsAttitudeConstant) {
  FlightParams params = of_kind("line");
  params.drift_m_s = 43;
  params.drift_heading_rad = -1.1;
  params.off_nadir_rad = 0.2;
  const std::vector<CameraState> states = fly(params);
  const Vec3 velocity = 43 * Vec3(std::cos(-1.1), std::sin(-1.1), 0);
  for (const CameraState& s : states) {
    const Vec3 expected = Vec3(0, 0, params.altitude_m) + velocity * (1e-9 * static_cast<double>(s.time_ns));
    EXPECT_NEAR((s.centre - expected).norm(), 0, 1e-9);
    EXPECT_NEAR((s.rotation - states.front().rotation).norm(), 0, 1e-12);
  }
}

TEST(Flight, DescentMovesAlongTheOpticalAxis) {
  FlightParams params = of_kind("descent");
  params.altitude_m = 500;
  params.descent_m_s = 3;
  params.off_nadir_rad = 0.35;
  params.off_nadir_azimuth_rad = 2.2;
  const std::vector<CameraState> states = fly(params);
  for (std::size_t k = 1; k < states.size(); ++k) {
    const Vec3 step = states[k].centre - states[k - 1].centre;
    EXPECT_NEAR((step - 3 * params.interval_s * optical_axis(states[0])).norm(), 0, 1e-9);
    EXPECT_NEAR((states[k].rotation - states[0].rotation).norm(), 0, 1e-12);
  }
  EXPECT_NEAR(states.front().centre.z() - states.back().centre.z(), 3 * 2 * 69 * std::cos(0.35), 1e-8);
}

TEST(Flight, DescentWithARatioShrinksTheHeightByTheSameFactorBetweenAllFramesAndDriftsAcross) {
  FlightParams params = of_kind("descent");
  params.altitude_m = 540;
  params.frames = 60;
  params.descent_ratio = 90;
  params.descent_drift = 0.3;
  params.drift_heading_rad = 0.5;
  const std::vector<CameraState> states = fly(params);
  ASSERT_EQ(states.size(), 60U);
  EXPECT_NEAR(states.front().centre.z(), 540, 1e-9);
  EXPECT_NEAR(states.back().centre.z(), 6, 1e-8);
  for (std::size_t k = 1; k < states.size(); ++k) {
    EXPECT_NEAR(states[k].centre.z() / states[k - 1].centre.z(), std::pow(90, -1.0 / 59), 1e-9) << k;
    const double across = 0.3 * (540 - states[k].centre.z());
    EXPECT_NEAR(states[k].centre.x(), across * std::cos(0.5), 1e-8);
    EXPECT_NEAR(states[k].centre.y(), across * std::sin(0.5), 1e-8);
    EXPECT_NEAR((states[k].rotation - states[0].rotation).norm(), 0, 1e-12);
  }
  EXPECT_NEAR(optical_axis(states[0]).z(), -1, 1e-12);
}

TEST(Flight, HoverStaysOverItsPlaceWhileItSwingsAndTurns) {
  FlightParams params = of_kind("hover");
  params.yaw_rate_rad_s = 0.02;
  double turned = 0;
  const std::vector<CameraState> states = fly(params);
  for (const CameraState& s : states) {
    EXPECT_LT(s.centre.head<2>().norm(), 1.2 * params.swing_rad * params.suspension_m);
    turned = std::max(turned, std::acos(std::min(1.0, s.rotation.row(0).dot(states[0].rotation.row(0)))));
  }
  EXPECT_GT(turned, 2.5);
  EXPECT_GT((states[3].centre - states[0].centre).norm(), 0.01);
}

TEST(Flight, CameraLooksOffNadirByTheAngleAndTowardsTheSideItIsTold) {
  for (const double angle : {0.0, 0.1, 0.7}) {
    for (const double azimuth : {0.0, 1.2, -2.0}) {
      FlightParams params = of_kind("line");
      params.off_nadir_rad = angle;
      params.off_nadir_azimuth_rad = azimuth;
      params.drift_heading_rad = 0.4;
      const Vec3 axis = optical_axis(fly(params).front());
      const Vec3 expected(std::sin(angle) * std::cos(0.4 + azimuth), std::sin(angle) * std::sin(0.4 + azimuth),
                          -std::cos(angle));
      EXPECT_NEAR((axis - expected).norm(), 0, 1e-12) << angle << " towards " << azimuth;
    }
  }
}

TEST(Flight, SteadyYawTurnsTheImageAtItsRate) {
  FlightParams params = of_kind("hover");
  params.swing_rad = 0;
  params.yaw_rad = 0;
  params.yaw_rate_rad_s = 0.05;
  const Trajectory trajectory(params);
  const CameraState a = trajectory.at(0), b = trajectory.at(10'000'000'000);
  // Counterclockwise seen from above: the image's x axis turns from the world's x towards y.
  EXPECT_NEAR(a.rotation(0, 0), 1, 1e-12);
  EXPECT_NEAR(b.rotation(0, 0), std::cos(0.5), 1e-12);
  EXPECT_NEAR(b.rotation(0, 1), std::sin(0.5), 1e-12);
}

TEST(Flight, MotionIsTheDerivativeOfTheState) {
  for (const FlightParams& params : all_kinds()) {
    const Trajectory trajectory(params);
    constexpr std::int64_t dt = 1'000'000;
    for (std::int64_t t = dt; t + dt < trajectory.end_ns(); t += 777'777'777) {
      const CameraMotion motion = trajectory.motion(t);
      const CameraState before = trajectory.at(t - dt), after = trajectory.at(t + dt);
      const Vec3 velocity = (after.centre - before.centre) / 2e-3;
      EXPECT_NEAR((motion.velocity_m_s - velocity).norm(), 0, 1e-6) << params.kind << " at " << t;
      // R(t + dt) = exp([turn dt]x) R(t): the antisymmetric part of R' R^T.
      const Mat3 rate = (after.rotation - before.rotation) / 2e-3 * motion.state.rotation.transpose();
      const Vec3 turn(rate(2, 1), rate(0, 2), rate(1, 0));
      EXPECT_NEAR((motion.turn_rad_s - turn).norm(), 0, 1e-7) << params.kind << " at " << t;
      EXPECT_NEAR((rate + rate.transpose()).norm(), 0, 1e-6);
    }
  }
}

TEST(Flight, PositionAttitudeAndTheirRatesAreContinuous) {
  for (const FlightParams& params : all_kinds()) {
    const Trajectory trajectory(params);
    constexpr std::int64_t dt = 20'000'000;
    CameraMotion last = trajectory.motion(0);
    for (std::int64_t t = dt; t < trajectory.end_ns(); t += dt) {
      const CameraMotion now = trajectory.motion(t);
      // Within 20 ms: nothing here accelerates faster than 1 m/s^2 or 0.1 rad/s^2.
      ASSERT_LT((now.velocity_m_s - last.velocity_m_s).norm(), 0.02) << params.kind << " at " << t;
      ASSERT_LT((now.turn_rad_s - last.turn_rad_s).norm(), 0.002) << params.kind << " at " << t;
      ASSERT_LT((now.state.centre - last.state.centre - 0.02 * last.velocity_m_s).norm(), 2e-4) << params.kind;
      ASSERT_LT((now.state.rotation - last.state.rotation).norm(), 0.01) << params.kind;
      last = now;
    }
  }
}

TEST(Flight, GapLeavesNoExposuresWhileTheFlightGoesOn) {
  FlightParams params{.gap_start_s = 40, .gap_length_s = 21};
  const Trajectory trajectory(params);
  params.gap_length_s = 0;
  const Trajectory whole(params);
  std::vector<std::int64_t> expected;
  for (const std::int64_t t : whole.exposures()) {
    if (t < 40'000'000'000 || t >= 61'000'000'000) expected.push_back(t);
  }
  EXPECT_EQ(expected.size(), 59U);
  EXPECT_EQ(trajectory.exposures(), expected);
  EXPECT_EQ(trajectory.at(100'000'000'000).centre, whole.at(100'000'000'000).centre);
}

TEST(Flight, RevisitReturnsOverOldGround) {
  for (const char* kind : {"balloon", "line"}) {
    FlightParams params = of_kind(kind);
    params.meander_m = 0;
    params.gust_m_s = 0;
    params.revisit = 0.5;
    params.revisit_yaw_rad = pi;
    const std::vector<CameraState> states = fly(params);
    double farthest = 0;
    for (const CameraState& s : states) farthest = std::max(farthest, s.centre.x());
    // Out for 69 s less what turning takes away, and back.
    EXPECT_GT(farthest, 2.5 * 45) << kind;
    EXPECT_LT(farthest, 2.5 * 69) << kind;
    EXPECT_GT(overlap(params.camera, states.front(), states.back()), 0.8) << kind;
    EXPECT_LT(states.front().rotation.row(0).dot(states.back().rotation.row(0)), -0.9) << "the turn turns the camera";
    params.revisit_offset_m = 30;
    EXPECT_NEAR(fly(params).back().centre.y() - states.back().centre.y(), 30, 0.5) << kind;
  }
}

TEST(Flight, InstantsOutsideTheFlightAreRefused) {
  const Trajectory trajectory{FlightParams()};
  EXPECT_GT(trajectory.end_ns(), trajectory.exposures().back());
  EXPECT_NO_THROW((void)trajectory.at(trajectory.end_ns()));
  EXPECT_THROW((void)trajectory.at(trajectory.end_ns() + 1), std::out_of_range);
  EXPECT_THROW((void)trajectory.at(-1), std::out_of_range);
}

std::string complaint(const FlightParams& params) {
  return test::error_of<std::invalid_argument>([&] { (void)fly(params); });
}

template <typename Number>
CameraModel camera_with(Number CameraModel::*field, Number value) {
  CameraModel camera = default_camera();
  camera.*field = value;
  return camera;
}

TEST(Flight, EveryNumberOutsideItsRangeIsNamed) {
  FlightParams model;
  for (std::size_t k = 0; k < parameters(model).size(); ++k) {
    const std::string name(parameters(model)[k].name);
    const auto set = [&](double value) {
      FlightParams params;
      const Parameter parameter = parameters(params)[k];
      if (double* const* number = std::get_if<double*>(&parameter.field)) **number = value;
      if (int* const* number = std::get_if<int*>(&parameter.field)) **number = value < 0 ? -1000 : 1'000'000;
      return complaint(params);
    };
    const Parameter parameter = parameters(model)[k];
    if (!std::holds_alternative<double*>(parameter.field) && !std::holds_alternative<int*>(parameter.field)) continue;
    EXPECT_NE(set(-1e12).find("[flight] " + name + " ="), std::string::npos) << name << ": " << set(-1e12);
    EXPECT_NE(set(1e12).find("[flight] " + name + " ="), std::string::npos) << name << ": " << set(1e12);
    if (std::holds_alternative<int*>(parameter.field)) continue;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(set(nan).find("[flight] " + name + " ="), std::string::npos) << name << ": " << set(nan);
  }
}

TEST(Flight, ParametersThatContradictEachOtherAreNamed) {
  const std::pair<FlightParams, const char*> contradictions[] = {
      {{.kind = "rocket"}, "kind = rocket: expected balloon, line, hover or descent"},
      {{.kind = "descent", .descent_m_s = 2}, "descent_m_s = 2: expected a descent that ends above the ground"},
      {{.gap_length_s = 1000}, "gap_length_s = 1000"},
      {{.descent_ratio = 0.5}, "descent_ratio = 0.5: expected at least 1, or 0"},
      {{.kind = "hover", .revisit = 0.5}, "revisit = 0.5"},
      {{.gust_m_s = 30}, "gust_m_s"},
      {{.frames = 9999, .interval_s = 9000}, "gust_time_s = 20"},
      {{.frames = 9999, .interval_s = 9000, .gust_time_s = 10000}, "suspension_m = 15"},
      {{.camera = camera_with(&CameraModel::fx, -1.0)}, "[camera] fx = -1"},
      {{.camera = camera_with(&CameraModel::width, 5000)}, "[camera] width = 5000"},
      {{.camera = camera_with(&CameraModel::k1, -3.0)},
       "[camera]: argument distortion (expected: invertible over the whole image)"},
  };
  for (const auto& [params, named] : contradictions) EXPECT_TRUE(test::says(complaint(params), named)) << named;
}

TEST(Flight, NegativePrincipalPointIsTheCentreOfTheImage) {
  CameraModel camera = default_camera();
  camera.width = 321;
  camera.height = 200;
  camera.cx = camera.cy = -1;
  EXPECT_EQ(centred(camera).cx, 160);
  EXPECT_EQ(centred(camera).cy, 99.5);
  camera.cx = 12.25;
  EXPECT_EQ(centred(camera).cx, 12.25);
}

}  // namespace
}  // namespace ilp::world
