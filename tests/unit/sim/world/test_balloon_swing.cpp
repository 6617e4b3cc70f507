#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "sim/world/flight.hpp"

namespace ilp::sim {
namespace {

// A gondola that hangs on its balloon looks towards the side to which it has swung.
TEST(BalloonSwing, CameraLooksAwayFromThePivot) {
  FlightParams params;
  params.drift_m_s = 0;
  params.meander_m = 0;
  params.altitude_oscillation = 0;
  params.drift_heading_rad = 0.7;
  const Vec3 pivot(0, 0, params.altitude_m + params.suspension_m);
  for (const CameraState& s : fly(params)) {
    const Vec3 axis = s.rotation.transpose() * Vec3(0, 0, 1);
    EXPECT_NEAR((s.centre - pivot - params.suspension_m * axis).norm(), 0, 1e-9);
  }
}

// The header promises it: what a frame interval and a target overlap are chosen by.
TEST(BalloonSwing, ConsecutiveFramesOverlapAsStated) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    FlightParams params;
    params.seed = seed;
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
      EXPECT_GT(share, 0.92) << "seed " << seed << ", frame " << n;
      EXPECT_LT(share, 0.97) << "seed " << seed << ", frame " << n;
      mean += share / static_cast<double>(states.size() - 1);
    }
    EXPECT_GT(mean, 0.94) << "seed " << seed;
    EXPECT_LT(mean, 0.96) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ilp::sim
