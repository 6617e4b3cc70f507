// The renderer's geometry by independent routes: points projected by formulas written out here, and corners found
// again.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "sim/world/renderer.hpp"
#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

CameraModel distorting_camera() {
  CameraModel camera{640, 480, 550, 556, 311, 246, -0.12, 0.03, 0.0015, -0.001};
  return camera;
}

CameraMotion looking(double x, double y, double z, double tilt_x, double tilt_y, double yaw) {
  const auto turn = [](double angle, const Vec3& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); };
  CameraMotion motion;
  motion.state.rotation = turn(tilt_x, Vec3::UnitX()) * turn(tilt_y, Vec3::UnitY()) * turn(yaw, Vec3::UnitZ()) *
                          Mat3(Vec3(1, -1, -1).asDiagonal());
  motion.state.centre = Vec3(x, y, z);
  return motion;
}

struct Pixel {
  double u = 0, v = 0, depth = 0;
};

/// Brown's model (OpenCV's order k1 k2 p1 p2), from a point of the world.
Pixel project(const CameraModel& m, const CameraState& state, const Vec3& point) {
  const Vec3 c = state.rotation * (point - state.centre);
  const double x = c.x() / c.z(), y = c.y() / c.z(), r2 = x * x + y * y;
  const double radial = 1 + m.k1 * r2 + m.k2 * r2 * r2;
  const double xd = x * radial + 2 * m.p1 * x * y + m.p2 * (r2 + 2 * x * x);
  const double yd = y * radial + m.p1 * (r2 + 2 * y * y) + 2 * m.p2 * x * y;
  return {m.fx * xd + m.cx, m.fy * yd + m.cy, c.z()};
}

/// The point at a depth behind a pixel; distortion undone by fixed-point iteration.
Vec3 back_project(const CameraModel& m, const CameraState& state, double u, double v, double depth) {
  const double xd = (u - m.cx) / m.fx, yd = (v - m.cy) / m.fy;
  double x = xd, y = yd;
  for (int step = 0; step < 60; ++step) {
    const double r2 = x * x + y * y, radial = 1 + m.k1 * r2 + m.k2 * r2 * r2;
    const double dx = 2 * m.p1 * x * y + m.p2 * (r2 + 2 * x * x), dy = m.p1 * (r2 + 2 * y * y) + 2 * m.p2 * x * y;
    x = (xd - dx) / radial;
    y = (yd - dy) / radial;
  }
  return state.centre + state.rotation.transpose() * (depth * Vec3(x, y, 1));
}

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

// The world's heights, through pose and lens, against the depth map at the pixel where they land.
TEST(RenderGeometry, PointsOfTheWorldLandOnTheirPixels) {
  const CameraModel camera = distorting_camera();
  const Terrain terrain{WorldParams()};
  const Renderer renderer(terrain, camera, {}, 1);
  for (const CameraMotion& motion : {looking(40, -25, 100, 0.08, -0.05, 0.4), looking(-7, 12, 60, -0.3, 0.2, 2.5),
                                     looking(0, 0, 40, 0.6, 0.1, -1)}) {
    RenderedFrame frame;
    renderer.render(motion, 0, frame);
    double worst_px = 0, worst_depth = 0;
    for (int v = 0; v < camera.height; v += 23) {
      for (int u = 0; u < camera.width; u += 19) {
        const double depth = frame.depth_m.at(u, v);
        const Vec3 seen = back_project(camera, motion.state, u, v, depth);
        const Vec3 ground(seen.x(), seen.y(), terrain.height(seen.x(), seen.y()));
        const Pixel pixel = project(camera, motion.state, ground);
        worst_px = std::max(worst_px, std::hypot(pixel.u - u, pixel.v - v));
        worst_depth = std::max(worst_depth, std::fabs(pixel.depth / depth - 1));
      }
    }
    EXPECT_LT(worst_px, 0.01);
    EXPECT_LT(worst_depth, 1e-4);
    RecordProperty("worst_px", std::to_string(worst_px));
  }
}

struct Redetection {
  std::vector<double> error_px;
  double mean_x = 0, mean_y = 0;
};

Redetection redetect(const CameraModel& camera, const RenderedFrame& a, const CameraState& state_a,
                     const RenderedFrame& b, const CameraState& state_b) {
  const auto workspace = std::make_unique<HarrisWorkspace>();
  const auto in_a = std::make_unique<Corners>(), in_b = std::make_unique<Corners>();
  EXPECT_TRUE(detect_corners(a.grey.view(), {}, *workspace, *in_a).ok());
  EXPECT_TRUE(detect_corners(b.grey.view(), {}, *workspace, *in_b).ok());
  Redetection result;
  for (const Corner& corner : *in_a) {
    const int i = static_cast<int>(corner.x), j = static_cast<int>(corner.y);
    const double s = static_cast<double>(corner.x) - i, t = static_cast<double>(corner.y) - j;
    const double depth = (1 - t) * ((1 - s) * a.depth_m.at(i, j) + s * a.depth_m.at(i + 1, j)) +
                         t * ((1 - s) * a.depth_m.at(i, j + 1) + s * a.depth_m.at(i + 1, j + 1));
    const Pixel p = project(camera, state_b, back_project(camera, state_a, corner.x, corner.y, depth));
    double nearest = 1.5, dx = 0, dy = 0;
    for (const Corner& other : *in_b) {
      const double distance = std::hypot(other.x - p.u, other.y - p.v);
      if (distance < nearest) {
        nearest = distance;
        dx = other.x - p.u;
        dy = other.y - p.v;
      }
    }
    if (nearest == 1.5) continue;
    result.error_px.push_back(nearest);
    result.mean_x += dx;
    result.mean_y += dy;
  }
  result.mean_x /= static_cast<double>(result.error_px.size());
  result.mean_y /= static_cast<double>(result.error_px.size());
  return result;
}

TEST(RenderGeometry, CornersAreFoundAgainWhereDepthAndPosesSay) {
  const CameraModel camera = distorting_camera();
  const Terrain terrain{WorldParams()};
  for (const double psf_sigma_px : {0.0, 0.5}) {
    CameraEffects effects{.psf_sigma_px = psf_sigma_px};
    const Renderer renderer(terrain, camera, effects, 1);
    const CameraMotion first = looking(40, -25, 100, 0.02, -0.03, 0.1);
    RenderedFrame a;
    renderer.render(first, 0, a);
    for (const CameraMotion& second :
         {looking(45, -25, 100, 0.0, -0.01, 0.12), looking(50, -20, 101, -0.02, 0.02, 0.2)}) {
      RenderedFrame b;
      renderer.render(second, 1, b);
      const Redetection found = redetect(camera, a, first.state, b, second.state);
      const double median = quantile(found.error_px, 0.5), p95 = quantile(found.error_px, 0.95);
      std::cout << "point spread " << psf_sigma_px << " px: " << found.error_px.size() << " corners, median " << median
                << " px, 95 % " << p95 << " px, mean (" << found.mean_x << ", " << found.mean_y << ") px\n";
      EXPECT_GT(found.error_px.size(), 300U);
      // Without a point spread the finest detail is sampled too coarsely for a corner to keep its place.
      EXPECT_LT(median, psf_sigma_px > 0 ? 0.1 : 0.12);
      EXPECT_LT(std::hypot(found.mean_x, found.mean_y), 0.03);
    }
  }
}

TEST(RenderGeometry, ViewsUpToSixtyDegreesOffNadirAreRendered) {
  CameraModel camera = distorting_camera();
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 137.5;
  camera.cx = 79.5;
  camera.cy = 59.5;
  WorldParams world;
  world.post_spacing_m = 0.8;
  world.shortest_wavelength_m = 2;
  world.smallest_crater_radius_m = 2;
  world.smallest_rock_radius_m = 0.8;
  const Terrain terrain(world);
  const Renderer renderer(terrain, camera, {}, 1);
  for (const double tilt : {0.5, 1.0471975}) {
    const CameraMotion motion = looking(0, 0, 100, tilt, 0, 0.3);
    RenderedFrame frame;
    renderer.render(motion, 0, frame);
    for (int v = 0; v < camera.height; v += 3) {
      for (int u = 0; u < camera.width; u += 3) {
        const Vec3 seen = back_project(camera, motion.state, u, v, frame.depth_m.at(u, v));
        ASSERT_NEAR(terrain.height(seen.x(), seen.y()), seen.z(), 1e-4 * frame.depth_m.at(u, v)) << u << "," << v;
      }
    }
  }
}

TEST(RenderGeometry, ViewThatIsNotBoundedByGroundIsRefusedWithItsReason) {
  const Terrain terrain{WorldParams()};
  const Renderer renderer(terrain, distorting_camera(), {}, 1);
  const auto complaint = [&](const CameraMotion& motion) -> std::string {
    RenderedFrame frame;
    return test::error_of([&] { renderer.render(motion, 0, frame); });
  };
  const std::string low = complaint(looking(0, 0, 5, 0, 0, 0));
  EXPECT_NE(low.find("5 m"), std::string::npos) << low;
  std::ostringstream highest;
  highest << terrain.highest() << " m";
  EXPECT_NE(low.find(highest.str()), std::string::npos) << low << ", but the ground reaches " << highest.str();
  const std::string level = complaint(looking(0, 0, 100, 1.3, 0, 0));
  EXPECT_NE(level.find("74.5 degrees"), std::string::npos) << level;
  const std::string nan = complaint(looking(0, 0, std::nan(""), 0, 0, 0));
  EXPECT_NE(nan, "");
}

}  // namespace
}  // namespace ilp::world
