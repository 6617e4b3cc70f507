#include "sim/sil/nominal_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp::sil {
namespace {

const CameraModel truth{640, 480, 550, 550, 319.5, 239.5, -0.08, 0.01, 0.0004, -0.0003};

TEST(NominalCamera, IsOffByUpTo15PercentAndDiffersFromSeedToSeed) {
  double least = 1, most = 1, farthest_px = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const CameraModel camera = nominal_camera(truth, seed);
    EXPECT_TRUE(validate(camera).ok()) << seed;
    EXPECT_EQ(camera.width, truth.width);
    EXPECT_DOUBLE_EQ(camera.fx, camera.fy);
    least = std::min(least, camera.fx / truth.fx);
    most = std::max(most, camera.fx / truth.fx);
    farthest_px = std::max({farthest_px, std::fabs(camera.cx - truth.cx), std::fabs(camera.cy - truth.cy)});
    EXPECT_EQ(camera.fx, nominal_camera(truth, seed).fx) << "the same again";
  }
  EXPECT_GE(least, 0.85);
  EXPECT_LT(least, 0.87);
  EXPECT_LE(most, 1.15);
  EXPECT_GT(most, 1.13);
  EXPECT_LE(farthest_px, 6.4);
  EXPECT_GT(farthest_px, 6);
}

TEST(NominalCamera, BendsTheSamePixels) {
  CameraModel camera = nominal_camera(truth, 7);
  camera.cx = truth.cx;
  camera.cy = truth.cy;
  for (const Vec2& pixel : {Vec2(0, 0), Vec2(639, 479), Vec2(100, 400)}) {
    const Vec2 ours = ideal_from_pixel(camera, pixel) - pixel, real = ideal_from_pixel(truth, pixel) - pixel;
    EXPECT_GT(real.norm(), 1);
    EXPECT_NEAR((ours - real).norm(), 0, 1e-6);
  }
}

}  // namespace
}  // namespace ilp::sil
