#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "sim/world/flight.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::sim {
namespace {

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

TEST(Flight, DefaultTrackGivesTheOverlapCheckerSomethingToChoose) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    FlightParams params;
    params.seed = seed;
    const std::vector<CameraState> states = fly(params);
    ASSERT_EQ(states.size(), static_cast<std::size_t>(params.frames));
    std::size_t keyframe = 0;
    int keyframes = 1;
    for (std::size_t k = 1; k < states.size(); ++k) {
      const double consecutive = overlap(params.camera, states[k - 1], states[k]);
      EXPECT_GT(consecutive, 0.91) << "seed " << seed << " frame " << k;
      EXPECT_LT(consecutive, 0.985) << "seed " << seed << " frame " << k;
      if (overlap(params.camera, states[keyframe], states[k]) > 0.82) continue;
      keyframe = k;
      ++keyframes;
    }
    EXPECT_GE(keyframes, 14) << "seed " << seed;
    EXPECT_LE(keyframes, 26) << "seed " << seed;
  }
}

TEST(Flight, AttitudeIsARotationThatLooksDownWithinItsSwing) {
  const FlightParams params;
  const double least_cosine = std::cos(1.25 * params.swing_rad);
  double tilted_most = 1;
  for (const CameraState& state : fly(params)) {
    EXPECT_NEAR((state.rotation * state.rotation.transpose() - Mat3::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(state.rotation.determinant(), 1, 1e-12);
    const double down = -state.rotation(2, 2);
    EXPECT_GT(down, least_cosine);
    tilted_most = std::min(tilted_most, down);
    EXPECT_GT(state.rotation(0, 0), std::cos(params.yaw_rad) - 0.01) << "the image's x axis points along the drift";
    EXPECT_NEAR(state.centre.z(), params.altitude_m, 0.035 * params.altitude_m);
  }
  EXPECT_LT(tilted_most, std::cos(0.7 * params.swing_rad)) << "it does swing";
}

TEST(Flight, DriftsTheDistanceItIsToldInTheDirectionItIsTold) {
  FlightParams params;
  params.drift_heading_rad = 2;
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

std::string complaint(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Flight, ParametersOutOfRangeAreNamed) {
  const auto flight = [](auto change) {
    FlightParams params;
    change(params);
    return complaint([&] { (void)fly(params); });
  };
  EXPECT_NE(flight([](FlightParams& p) { p.frames = 0; }).find("frames"), std::string::npos);
  EXPECT_NE(flight([](FlightParams& p) { p.altitude_m = std::nan(""); }).find("altitude_m"), std::string::npos);
  EXPECT_NE(flight([](FlightParams& p) { p.camera.fx = -1; }).find("camera"), std::string::npos);
  const auto world = [](auto change) {
    WorldParams params;
    change(params);
    return complaint([&] { const Terrain terrain(params); });
  };
  EXPECT_NE(world([](WorldParams& p) { p.relief_m = -1; }).find("relief_m"), std::string::npos);
  EXPECT_NE(world([](WorldParams& p) { p.post_spacing_m = 0; }).find("post_spacing_m"), std::string::npos);
  EXPECT_NE(world([](WorldParams& p) { p.sun_elevation_rad = std::nan(""); }).find("sun_elevation"), std::string::npos);
}

}  // namespace
}  // namespace ilp::sim
