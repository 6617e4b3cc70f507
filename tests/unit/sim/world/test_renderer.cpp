#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::sim {
namespace {

CameraModel small_camera() {
  CameraModel camera = default_camera();
  camera.width = 320;
  camera.height = 240;
  camera.fx = 280;
  camera.fy = 270;
  camera.cx = 163.2;
  camera.cy = 117.9;
  return camera;
}

CameraModel distorted_camera() {
  CameraModel camera = small_camera();
  camera.k1 = -0.12;
  camera.k2 = 0.03;
  camera.p1 = 0.002;
  camera.p2 = -0.003;
  return camera;
}

/// World to pixel, written down from the definition of the camera model (COLMAP, OPENCV).
Vec3 project(const CameraModel& k, const CameraState& s, const Vec3& world) {
  const Vec3 c = s.rotation * (world - s.centre);
  const double x = c.x() / c.z();
  const double y = c.y() / c.z();
  const double r2 = x * x + y * y;
  const double radial = 1 + k.k1 * r2 + k.k2 * r2 * r2;
  const double xd = x * radial + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x);
  const double yd = y * radial + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y;
  return {k.fx * xd + k.cx, k.fy * yd + k.cy, c.z()};
}

/// The point at depth z that projects to (u, v), by Newton's method on project() with numerical derivatives.
Vec3 back_project(const CameraModel& k, const CameraState& s, double u, double v, double z) {
  Vec2 n((u - k.cx) / k.fx, (v - k.cy) / k.fy);
  const auto world = [&](const Vec2& at) {
    return Vec3(s.centre + s.rotation.transpose() * Vec3(at.x() * z, at.y() * z, z));
  };
  for (int step = 0; step < 8; ++step) {
    const Vec2 here = project(k, s, world(n)).head<2>();
    constexpr double h = 1e-6;
    Eigen::Matrix2d jacobian;
    jacobian.col(0) = (project(k, s, world(n + Vec2(h, 0))).head<2>() - here) / h;
    jacobian.col(1) = (project(k, s, world(n + Vec2(0, h))).head<2>() - here) / h;
    n -= jacobian.inverse() * (here - Vec2(u, v));
  }
  return world(n);
}

template <typename T>
double bilinear(const Image<T>& image, double x, double y) {
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const double u = x - i;
  const double v = y - j;
  return (1 - v) * ((1 - u) * image.at(i, j) + u * image.at(i + 1, j)) +
         v * ((1 - u) * image.at(i, j + 1) + u * image.at(i + 1, j + 1));
}

class RendererWithCamera : public testing::TestWithParam<bool> {
 protected:
  CameraModel camera = GetParam() ? distorted_camera() : small_camera();
};

TEST_P(RendererWithCamera, DepthEndsOnTheGround) {
  const Terrain terrain{WorldParams{}};
  FlightParams params;
  params.camera = camera;
  const CameraState state = fly(params)[13];
  RenderedFrame frame;
  Renderer(terrain, camera, 0).render(state, 1, frame);
  Rng rng(5);
  for (int n = 0; n < 400; ++n) {
    // The corners too: that is where distortion is largest.
    const int u = n < 4 ? (n % 2) * (camera.width - 1) : static_cast<int>(rng.below(320));
    const int v = n < 4 ? (n / 2) * (camera.height - 1) : static_cast<int>(rng.below(240));
    const Vec3 point = back_project(camera, state, u, v, frame.depth_m.at(u, v));
    ASSERT_NEAR(point.z(), terrain.height(point.x(), point.y()), 1e-3) << u << " " << v;
  }
}

struct Motion {
  double x_px = 0, y_px = 0, rms_grey = 0;
  int pixels = 0;
};

/// How far frame b, brought back to frame a through the true depth and poses, still seems displaced inside a window:
/// one step of Lucas and Kanade (1981), exact for small displacements.
Motion residual_motion(const CameraModel& k, const CameraState& sa, const RenderedFrame& a, const CameraState& sb,
                       const RenderedFrame& b, int x0, int y0, int x1, int y1) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vec2 right = Vec2::Zero();
  Motion motion;
  for (int v = std::max(1, y0); v < std::min(y1, k.height - 1); v += 2) {
    for (int u = std::max(1, x0); u < std::min(x1, k.width - 1); u += 2) {
      const Vec3 q = project(k, sb, back_project(k, sa, u, v, a.depth_m.at(u, v)));
      if (q.x() < 1 || q.y() < 1 || q.x() > k.width - 2 || q.y() > k.height - 2) continue;
      if (std::fabs(bilinear(b.depth_m, q.x(), q.y()) - q.z()) > 0.1) continue;  // hidden in b
      const Vec2 gradient(0.5 * (a.grey.at(u + 1, v) - a.grey.at(u - 1, v)),
                          0.5 * (a.grey.at(u, v + 1) - a.grey.at(u, v - 1)));
      const double difference = bilinear(b.grey, q.x(), q.y()) - a.grey.at(u, v);
      normal += gradient * gradient.transpose();
      right += gradient * difference;
      motion.rms_grey += difference * difference;
      ++motion.pixels;
    }
  }
  if (motion.pixels == 0) return motion;
  const Vec2 shift = normal.inverse() * right;
  motion.x_px = shift.x();
  motion.y_px = shift.y();
  motion.rms_grey = std::sqrt(motion.rms_grey / motion.pixels);
  return motion;
}

// Images, poses and depths tell one story: errors of half a pixel, of a sign or of the distortion show here.
TEST_P(RendererWithCamera, FrameWarpedThroughTruthIsTheNextFrame) {
  const Terrain terrain{WorldParams{}};
  FlightParams params;
  params.camera = camera;
  const std::vector<CameraState> states = fly(params);
  const CameraState& sa = states[20];
  const CameraState& sb = states[23];
  RenderedFrame a, b;
  const Renderer renderer(terrain, camera, 0);
  renderer.render(sa, 1, a);
  renderer.render(sb, 2, b);
  int windows = 0;
  for (int y = 0; y < camera.height; y += 80) {
    for (int x = 0; x < camera.width; x += 80) {
      const Motion motion = residual_motion(camera, sa, a, sb, b, x, y, x + 80, y + 80);
      if (motion.pixels < 800) continue;
      ++windows;
      EXPECT_NEAR(motion.x_px, 0, 0.08) << x << " " << y;
      EXPECT_NEAR(motion.y_px, 0, 0.08) << x << " " << y;
      EXPECT_LT(motion.rms_grey, 8) << x << " " << y;
    }
  }
  EXPECT_GE(windows, 8);
}

INSTANTIATE_TEST_SUITE_P(Lens, RendererWithCamera, testing::Bool(),
                         [](const auto& info) { return info.param ? "Distorted" : "Ideal"; });

// A default frame, as the flight software will get it: well exposed, and with something to match everywhere.
TEST(Renderer, FrameIsWellExposedAndTexturedEverywhere) {
  const Terrain terrain{WorldParams{}};
  const FlightParams params;
  RenderedFrame frame;
  Renderer(terrain, params.camera, params.noise_grey).render(fly(params)[40], 1, frame);
  const auto [low, high] = std::minmax_element(frame.grey.pixels.begin(), frame.grey.pixels.end());
  EXPECT_GT(*low, 5);
  EXPECT_LT(*high, 250);
  double mean = 0;
  double weakest = 255;
  for (int y = 0; y < 480; y += 20) {
    for (int x = 0; x < 640; x += 20) {
      double sum = 0;
      double squares = 0;
      for (int v = y; v < y + 20; ++v) {
        for (int u = x; u < x + 20; ++u) {
          const double g = frame.grey.at(u, v);
          sum += g / 400;
          squares += g * g / 400;
        }
      }
      mean += sum / (24 * 32);
      weakest = std::min(weakest, std::sqrt(squares - sum * sum));
    }
  }
  EXPECT_GT(mean, 110);
  EXPECT_LT(mean, 140);
  EXPECT_GT(weakest, 5) << "grey levels of contrast in the weakest 20 px square";
}

TEST(Renderer, NoiseHasTheStatedDeviationAndNoBias) {
  const Terrain terrain{WorldParams{}};
  FlightParams params;
  params.camera = small_camera();
  const CameraState state = fly(params)[0];
  RenderedFrame quiet, noisy;
  Renderer(terrain, params.camera, 0).render(state, 1, quiet);
  Renderer(terrain, params.camera, 3).render(state, 1, noisy);
  double sum = 0;
  double squares = 0;
  for (std::size_t k = 0; k < quiet.grey.pixels.size(); ++k) {
    const double d = noisy.grey.pixels[k] - quiet.grey.pixels[k];
    sum += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(quiet.grey.pixels.size());
  EXPECT_NEAR(sum / n, 0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(9 + 2.0 / 12), 0.1);  // two roundings
}

TEST(Renderer, RefusesViewsThatMissTheGround) {
  const Terrain terrain{WorldParams{}};
  const Renderer renderer(terrain, small_camera(), 0);
  RenderedFrame frame;
  CameraState state;
  state.rotation = Vec3(1, -1, -1).asDiagonal();
  state.centre = Vec3(0, 0, 5);
  EXPECT_THROW(renderer.render(state, 1, frame), std::runtime_error) << "inside the relief";
  state.centre = Vec3(0, 0, 100);
  state.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // level
  EXPECT_THROW(renderer.render(state, 1, frame), std::runtime_error) << "horizon";
}

}  // namespace
}  // namespace ilp::sim
