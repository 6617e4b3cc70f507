// Image, depth, pose and ground say the same, with a lens that distorts.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"

namespace ilp::world {
namespace {

CameraModel distorting_camera(int scale) {
  CameraModel camera = default_camera();
  camera.width = 640 / scale;
  camera.height = 480 / scale;
  camera.fx = 550.0 / scale;
  camera.fy = 556.0 / scale;
  camera.cx = 311.0 / scale;
  camera.cy = 246.0 / scale;
  camera.k1 = -0.12;
  camera.k2 = 0.03;
  camera.p1 = 0.0015;
  camera.p2 = -0.001;
  return camera;
}

CameraState tilted_state() {
  CameraState state;
  // Nadir, then turned about all three axes; image x axis along the world's x, image y along the world's -y.
  const Mat3 nadir = Vec3(1, -1, -1).asDiagonal();
  const auto turn = [](double angle, const Vec3& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); };
  state.rotation = turn(0.08, Vec3::UnitX()) * turn(-0.05, Vec3::UnitY()) * turn(0.4, Vec3::UnitZ()) * nadir;
  state.centre = Vec3(40, -25, 100);
  return state;
}

Vec3 ground_point(const CameraModel& camera, const CameraState& state, int u, int v, double depth) {
  const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
  return state.centre + state.rotation.transpose() * (depth * Vec3(n.x(), n.y(), 1));
}

RenderedFrame render(const WorldParams& world, const CameraModel& camera, const CameraState& state,
                     const CameraEffects& effects = {}, std::int64_t frame_index = 0) {
  const Terrain terrain(world);
  CameraMotion motion{.state = state};
  RenderedFrame frame;
  Renderer(terrain, camera, effects, 1).render(motion, frame_index, frame);
  return frame;
}

TEST(RenderedTruth, DepthOverLevelGroundIsThatOfThePlane) {
  WorldParams world{.relief_m = 1e-6, .crater_density = 0, .rock_density = 0};
  const CameraModel camera = distorting_camera(4);
  const CameraState state = tilted_state();
  const RenderedFrame frame = render(world, camera, state);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
      const double down = -(state.rotation.transpose() * Vec3(n.x(), n.y(), 1)).z();
      ASSERT_NEAR(frame.depth_m.at(u, v), 100 / down, 1e-4) << u << "," << v;
    }
  }
}

TEST(RenderedTruth, DepthEndsOnTheGroundAndNothingStandsInTheWay) {
  WorldParams world{.relief_m = 25, .largest_rock_radius_m = 4};
  const Terrain terrain(world);
  const CameraModel camera = distorting_camera(4);
  const CameraState state = tilted_state();
  const RenderedFrame frame = render(world, camera, state);
  for (int v = 0; v < camera.height; v += 5) {
    for (int u = 0; u < camera.width; u += 5) {
      const double depth = frame.depth_m.at(u, v);
      const Vec3 hit = ground_point(camera, state, u, v, depth);
      ASSERT_NEAR(terrain.height(hit.x(), hit.y()), hit.z(), 1e-3) << u << "," << v;
      for (double before = 0.05; before < 12; before *= 1.5) {
        const Vec3 air = ground_point(camera, state, u, v, depth - before);
        ASSERT_LT(terrain.height(air.x(), air.y()), air.z()) << u << "," << v << " " << before << " m before";
      }
    }
  }
}

struct Comparison {
  double mean_abs = 0;              // grey, of the first image minus the second where it sees the same ground
  double shift_x = 0, shift_y = 0;  // px by which the second image is off, least squares
  std::size_t pixels = 0;
};

Comparison compare_warped(const CameraModel& camera, const RenderedFrame& a, const CameraState& state_a,
                          const RenderedFrame& b, const CameraState& state_b, double offset_px) {
  Comparison result;
  double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vec3 ground = ground_point(camera, state_a, u, v, a.depth_m.at(u, v));
      const Vec3 in_b = state_b.rotation * (ground - state_b.centre);
      const Vec2 p = pixel_from_normalised(camera, Vec2(in_b.x() / in_b.z(), in_b.y() / in_b.z()));
      const double x = p.x() + offset_px;
      const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(p.y()));
      if (i < 1 || j < 1 || i + 2 >= camera.width || j + 2 >= camera.height) continue;
      if (std::fabs(b.depth_m.at(i, j) - in_b.z()) > 0.3) continue;  // hidden in one of the two
      const double s = x - i, t = p.y() - j;
      const auto grey = [&](int di, int dj) { return static_cast<double>(b.grey.at(i + di, j + dj)); };
      const double value =
          (1 - t) * ((1 - s) * grey(0, 0) + s * grey(1, 0)) + t * ((1 - s) * grey(0, 1) + s * grey(1, 1));
      const double gx = (1 - s) * (grey(1, 0) - grey(-1, 0)) / 2 + s * (grey(2, 0) - grey(0, 0)) / 2;
      const double gy = (1 - t) * (grey(0, 1) - grey(0, -1)) / 2 + t * (grey(0, 2) - grey(0, 0)) / 2;
      const double difference = a.grey.at(u, v) - value;
      result.mean_abs += std::fabs(difference);
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
      xd += gx * difference;
      yd += gy * difference;
      ++result.pixels;
    }
  }
  result.mean_abs /= static_cast<double>(result.pixels);
  const double determinant = xx * yy - xy * xy;
  result.shift_x = (yy * xd - xy * yd) / determinant;
  result.shift_y = (xx * yd - xy * xd) / determinant;
  return result;
}

TEST(RenderedTruth, FrameWarpedByDepthAndPosesIsTheNextFrame) {
  FlightParams flight{.frames = 4, .camera = distorting_camera(1)};
  const std::vector<CameraState> states = fly(flight);
  const WorldParams world;
  const RenderedFrame a = render(world, flight.camera, states[0]);
  const RenderedFrame b = render(world, flight.camera, states[3]);
  const Comparison true_poses = compare_warped(flight.camera, a, states[0], b, states[3], 0);
  const Comparison one_px_off = compare_warped(flight.camera, a, states[0], b, states[3], 1);
  const double area = 640.0 * 480.0;
  EXPECT_GT(static_cast<double>(true_poses.pixels), 0.75 * area);
  EXPECT_LT(true_poses.mean_abs, 2.5);
  EXPECT_GT(one_px_off.mean_abs, 3 * true_poses.mean_abs);
  EXPECT_NEAR(true_poses.shift_x, 0, 0.05);
  EXPECT_NEAR(true_poses.shift_y, 0, 0.05);
}

// A shift between image and depth is the same in frames of one attitude and hides there; half a turn doubles it.
TEST(RenderedTruth, ImageAndDepthShareTheirPixelCentres) {
  const CameraModel camera = distorting_camera(2);
  const CameraState upright = tilted_state();
  CameraState turned = upright;
  turned.rotation = Vec3(-1, -1, 1).asDiagonal() * upright.rotation;
  const Comparison halves =
      compare_warped(camera, render({}, camera, upright), upright, render({}, camera, turned), turned, 0);
  EXPECT_GT(static_cast<double>(halves.pixels), 0.75 * 320 * 240);
  EXPECT_NEAR(halves.shift_x, 0, 0.05);
  EXPECT_NEAR(halves.shift_y, 0, 0.05);
}

TEST(RenderedTruth, SurfaceIsWellExposedAndTexturedEverywhere) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    WorldParams world{.seed = seed};
    FlightParams flight{.seed = seed, .frames = 30};
    const RenderedFrame frame = render(world, flight.camera, fly(flight)[29]);
    double mean = 0;
    std::size_t flat = 0, saturated = 0;
    for (const std::uint8_t grey : frame.grey.samples) {
      mean += grey / static_cast<double>(frame.grey.samples.size());
      saturated += grey < 3 || grey > 252;
    }
    for (int y = 0; y + 12 <= 480; y += 12) {
      for (int x = 0; x + 12 <= 640; x += 12) {
        double sum = 0, squares = 0;
        for (int k = 0; k < 144; ++k) {
          const double grey = frame.grey.at(x + k % 12, y + k / 12);
          sum += grey;
          squares += grey * grey;
        }
        flat += squares / 144 - sum * sum / (144 * 144) < 4 * 4;
      }
    }
    EXPECT_GT(mean, 105) << "seed " << seed;
    EXPECT_LT(mean, 150) << "seed " << seed;
    EXPECT_EQ(flat, 0U) << "seed " << seed;
    EXPECT_EQ(saturated, 0U) << "seed " << seed;
    const auto [nearest, farthest] = std::minmax_element(frame.depth_m.samples.begin(), frame.depth_m.samples.end());
    EXPECT_GT(*farthest - *nearest, 4) << "seed " << seed << ": hardly any relief in view";
  }
}

TEST(RenderedTruth, SensorNoiseHasItsStrengthAndBelongsToItsFrame) {
  const CameraModel camera = distorting_camera(4);
  CameraEffects noisy{.read_noise_grey = 3};
  const RenderedFrame clean = render({}, camera, tilted_state());
  const RenderedFrame one = render({}, camera, tilted_state(), noisy, 1);
  const RenderedFrame again = render({}, camera, tilted_state(), noisy, 1);
  const RenderedFrame other = render({}, camera, tilted_state(), noisy, 2);
  EXPECT_EQ(one.grey.samples, again.grey.samples);
  double squares = 0, product = 0;
  const double n = static_cast<double>(clean.grey.samples.size());
  for (std::size_t i = 0; i < clean.grey.samples.size(); ++i) {
    const double first = static_cast<double>(one.grey.samples[i]) - clean.grey.samples[i];
    const double second = static_cast<double>(other.grey.samples[i]) - clean.grey.samples[i];
    squares += first * first;
    product += first * second;
  }
  EXPECT_NEAR(std::sqrt(squares / n), 3, 0.2);
  EXPECT_LT(std::fabs(product / squares), 0.05);
}

TEST(RenderedTruth, CameraThatSeesNoGroundIsRefused) {
  const Terrain terrain{WorldParams()};
  const Renderer renderer(terrain, distorting_camera(4), {}, 1);
  RenderedFrame frame;
  CameraMotion up{.state = tilted_state()};
  up.state.rotation = Mat3::Identity();
  EXPECT_THROW(renderer.render(up, 0, frame), std::runtime_error);
  CameraMotion below{.state = tilted_state()};
  below.state.centre.z() = 2;
  EXPECT_THROW(renderer.render(below, 0, frame), std::runtime_error);
}

}  // namespace
}  // namespace ilp::world
