// Wind, pendulum and the gondola that hangs on them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "sim/world/balloon_swing.hpp"
#include "sim/world/flight.hpp"

namespace ilp::world {
namespace {

constexpr double pi = 3.14159265358979323846;

Pendulum still_air_pendulum(const PendulumParams& params, double duration_s) {
  const auto nothing = [](double) { return 0.0; };
  return {params, {nothing, nothing}, duration_s};
}

TEST(Wind, GustsHaveTheirDeviationAndCorrelationTime) {
  constexpr double deviation = 1.7;
  constexpr double time_constant = 8;
  constexpr double duration = 300'000;
  const Gusts gusts(deviation, time_constant, duration, Normal(Rng(5, 3)));
  const auto correlation = [&](double lag_s) {
    double sum = 0;
    int count = 0;
    for (double t = 0; t + lag_s < duration; t += 1, ++count) sum += gusts.at(t) * gusts.at(t + lag_s);
    return sum / count;
  };
  double mean = 0;
  for (int t = 0; t < static_cast<int>(duration); ++t) mean += gusts.at(t) / duration;
  // 18000 independent stretches of two time constants each: standard errors below 1 %.
  EXPECT_NEAR(mean, 0, 0.03 * deviation);
  EXPECT_NEAR(correlation(0) / (deviation * deviation), 1, 0.03);
  EXPECT_NEAR(correlation(0.5 * time_constant) / (deviation * deviation), std::exp(-0.5), 0.03);
  EXPECT_NEAR(correlation(time_constant) / (deviation * deviation), std::exp(-1.0), 0.03);
  EXPECT_NEAR(correlation(3 * time_constant) / (deviation * deviation), std::exp(-3.0), 0.03);
}

TEST(Wind, NormalNumbersHaveTheRightTails) {
  Normal normal(Rng(9));
  constexpr int count = 200'000;
  int beyond_one = 0, beyond_two = 0, beyond_three = 0;
  for (int k = 0; k < count; ++k) {
    const double x = std::fabs(normal.next());
    beyond_one += x > 1;
    beyond_two += x > 2;
    beyond_three += x > 3;
  }
  EXPECT_NEAR(beyond_one / double{count}, std::erfc(1 / std::sqrt(2.0)), 0.004);
  EXPECT_NEAR(beyond_two / double{count}, std::erfc(2 / std::sqrt(2.0)), 0.002);
  EXPECT_NEAR(beyond_three / double{count}, std::erfc(3 / std::sqrt(2.0)), 0.0005);
}

TEST(Wind, LongerFlightBeginsInTheSameWind) {
  const Gusts brief(0.5, 10, 60, Normal(Rng(2, 3)));
  const Gusts lasting(0.5, 10, 6000, Normal(Rng(2, 3)));
  for (double t = 0; t < 60; t += 0.37) EXPECT_EQ(brief.at(t), lasting.at(t)) << t;
}

TEST(Pendulum, FreeSwingIsTheAnalyticOne) {
  PendulumParams params{.length_m = 12, .gravity_m_s2 = 1.35, .damping = 0.04, .angle_rad = 0.1, .rate_rad_s = 0.01};
  const double w = std::sqrt(params.gravity_m_s2 / params.length_m);
  const double decay = params.damping * w;
  const double damped = w * std::sqrt(1 - params.damping * params.damping);
  const Pendulum pendulum = still_air_pendulum(params, 10 * 2 * pi / w);
  for (double t = 0; t < 10 * 2 * pi / w; t += 0.1) {
    const double sine = (params.rate_rad_s + decay * params.angle_rad) / damped;
    const double angle = std::exp(-decay * t) * (params.angle_rad * std::cos(damped * t) + sine * std::sin(damped * t));
    EXPECT_NEAR(pendulum.at(t).angle_rad, angle, 1e-5) << t;
  }
}

TEST(Pendulum, SteadyAccelerationTiltsItAgainstGravity) {
  PendulumParams params{.damping = 0.7};
  const Pendulum pendulum(params, {[](double) { return 0.0; }, [](double) { return 0.2; }}, 200);
  EXPECT_NEAR(pendulum.at(190).angle_rad, -0.2 / params.gravity_m_s2, 1e-6);
}

TEST(Pendulum, BalloonTakesOnTheSpeedOfAGustWithItsLag) {
  PendulumParams params{.balloon_lag_s = 4};
  const Pendulum pendulum(params, {[](double) { return 1.5; }, [](double) { return 0.0; }}, 100);
  for (const double t : {0.0, 1.0, 4.0, 13.0}) {
    EXPECT_NEAR(pendulum.at(t).speed_m_s, 1.5 * (1 - std::exp(-t / 4)), 2e-4) << t;
    EXPECT_NEAR(pendulum.at(t).shift_m, 1.5 * (t - 4 * (1 - std::exp(-t / 4))), 2e-4) << t;
  }
}

TEST(Pendulum, FlightTooLongToFollowIsRefused) {
  EXPECT_THROW(still_air_pendulum({}, 1e9), std::invalid_argument);
}

FlightParams still_balloon() {
  FlightParams params{
      .altitude_oscillation = 0, .drift_m_s = 0, .drift_heading_rad = 0.7, .meander_m = 0, .gust_m_s = 0};
  return params;
}

// A gondola that hangs on its balloon looks towards the side to which it has swung.
TEST(BalloonSwing, CameraLooksAwayFromThePivot) {
  const FlightParams params = still_balloon();
  const Vec3 pivot(0, 0, params.altitude_m + params.suspension_m);
  for (const CameraState& s : fly(params)) {
    const Vec3 axis = s.rotation.transpose() * Vec3(0, 0, 1);
    EXPECT_NEAR((s.centre - pivot - params.suspension_m * axis).norm(), 0, 1e-9);
  }
}

TEST(BalloonSwing, PeriodIsThatOfThePendulum) {
  FlightParams params = still_balloon();
  params.swing_damping = 0;
  params.yaw_rad = 0;
  params.suspension_m = 40;
  params.gravity_m_s2 = 8.87;
  params.interval_s = 10;
  const Trajectory trajectory(params);
  const Vec3 ahead(std::cos(0.7), std::sin(0.7), 0);
  const auto displaced = [&](std::int64_t t) { return trajectory.at(t).centre.dot(ahead); };
  std::vector<double> upward;  // zero crossings, s
  const std::int64_t step = 10'000'000;
  for (std::int64_t t = step; t < 600'000'000'000; t += step) {
    const double a = displaced(t - step), b = displaced(t);
    if (a < 0 && b >= 0) upward.push_back(1e-9 * (static_cast<double>(t - step) - a / (b - a) * step));
  }
  ASSERT_GT(upward.size(), 40U);
  const double period = (upward.back() - upward.front()) / static_cast<double>(upward.size() - 1);
  EXPECT_NEAR(period, 2 * pi * std::sqrt(40 / 8.87), 1e-3);
}

TEST(BalloonSwing, AmplitudeIsTheStatedOneAndHalfOfItAcross) {
  FlightParams params = still_balloon();
  params.swing_damping = 0;
  params.swing_rad = 0.04;
  params.yaw_rad = 0;
  const Trajectory trajectory(params);
  const Vec3 ahead(std::cos(0.7), std::sin(0.7), 0), left(-std::sin(0.7), std::cos(0.7), 0);
  double along = 0, across = 0;
  for (std::int64_t t = 0; t < trajectory.end_ns(); t += 50'000'000) {
    const Vec3 axis = trajectory.at(t).rotation.row(2);
    along = std::max(along, std::fabs(axis.dot(ahead)));
    across = std::max(across, std::fabs(axis.dot(left)));
  }
  EXPECT_NEAR(along, std::sin(0.04), 1e-4);
  EXPECT_NEAR(across, std::sin(0.02), 1e-4);
}

TEST(BalloonSwing, GustsPushTheBalloonAndSwingTheGondola) {
  FlightParams params = still_balloon();
  params.swing_rad = 0;
  params.frames = 1000;
  const std::vector<CameraState> calm = fly(params);
  params.gust_m_s = 0.07;
  double tilt = 0, shift = 0;
  for (std::size_t k = 0; const CameraState& s : fly(params)) {
    tilt += std::pow(std::acos(-s.rotation(2, 2)), 2);
    shift = std::max(shift, (s.centre - calm[k++].centre).norm());
  }
  tilt = std::sqrt(tilt / params.frames);
  EXPECT_GT(tilt, 0.003);
  EXPECT_LT(tilt, 0.03);
  EXPECT_GT(shift, 5);
}

// The header promises it: what a frame interval and a target overlap are chosen by.
TEST(BalloonSwing, ConsecutiveFramesOverlapAsStated) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    FlightParams params{.seed = seed};
    const CameraModel& k = params.camera;
    const std::vector<CameraState> states = fly(params);
    double mean = 0;
    for (std::size_t n = 1; n < states.size(); ++n) {
      const CameraState& a = states[n - 1];
      const CameraState& b = states[n];
      int inside = 0;
      int all = 0;
      for (double v = 1.5; v < k.height; v += 4) {
        for (double u = 1.5; u < k.width; u += 4, ++all) {
          const Vec3 d = a.rotation.transpose() * Vec3((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1);
          const Vec3 c = b.rotation * (a.centre - d * (a.centre.z() / d.z()) - b.centre);
          const double x = k.fx * c.x() / c.z() + k.cx;
          const double y = k.fy * c.y() / c.z() + k.cy;
          inside += x >= -0.5 && y >= -0.5 && x <= k.width - 0.5 && y <= k.height - 0.5;
        }
      }
      const double share = static_cast<double>(inside) / all;
      EXPECT_GT(share, 0.89) << "seed " << seed << ", frame " << n;
      EXPECT_LT(share, 0.99) << "seed " << seed << ", frame " << n;
      mean += share / static_cast<double>(states.size() - 1);
    }
    EXPECT_GT(mean, 0.94) << "seed " << seed;
    EXPECT_LT(mean, 0.96) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ilp::world
