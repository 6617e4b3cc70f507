// Points and images of a rolling shutter against cameras that move while they read.
#include "fsw/vision/geometry/rolling_shutter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "tests/support/middle_pixel.hpp"

namespace ilp {
namespace {

CameraModel rolling_camera(double readout_s) {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 550;
  camera.cx = 321;
  camera.cy = 238;
  camera.k1 = -0.08;
  camera.k2 = 0.01;
  camera.p1 = 0.0004;
  camera.p2 = -0.0003;
  camera.readout_s = readout_s;
  return camera;
}

/// A camera that turns and moves at constant rates above a tilted plane n P = distance, in its own axes.
struct Flight {
  Vec3 turn{0.11, -0.07, 0.05};  ///< rad/s
  Vec3 velocity{8, -6, 0.8};     ///< m/s
  Vec3 normal = Vec3(0.05, -0.08, 1).normalized();
  double distance = 100;

  /// Of what is at P in the axes of the middle row's time.
  [[nodiscard]] Vec3 at(const Vec3& p, double seconds) const {
    return rotation_from_vector(turn * seconds) * (p - velocity * seconds);
  }
  [[nodiscard]] ImageMotion motion() const {
    Mat3 m;
    m << 0, -turn.z(), turn.y(), turn.z(), 0, -turn.x(), -turn.y(), turn.x(), 0;
    m -= velocity * normal.transpose() / distance;
    ImageMotion motion;
    for (int i = 0; i < 8; ++i) motion.m[i] = m(i / 3, i % 3) - (i % 4 == 0 ? m(2, 2) : 0);
    return motion;
  }
};

Vec2 pixel_of(const CameraModel& camera, const Vec3& p) {
  return pixel_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z()));
}

// The flight's turns and speed are those of a drone that swings.
TEST(RollingShutter, MovesPointsOfAPlaneToTheMiddleRowWithinAHundredthOfAPixel) {
  const Flight flight;
  for (const double readout_s : {0.03, -0.03, 0.06}) {
    const CameraModel camera = rolling_camera(readout_s);
    double most_moved = 0;
    for (double v = 5; v < 480; v += 47) {
      for (double u = 5; u < 640; u += 63) {
        const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
        const Vec3 ray(n.x(), n.y(), 1);
        const Vec3 p = ray * (flight.distance / flight.normal.dot(ray));
        Vec2 seen(u, v);
        for (int i = 0; i < 30; ++i) seen = pixel_of(camera, flight.at(p, row_time_s(camera, seen.y())));
        most_moved = std::max(most_moved, (seen - Vec2(u, v)).norm());
        EXPECT_LT((test::middle_pixel(camera, flight.motion(), seen) - Vec2(u, v)).norm(), 0.01) << readout_s;
        EXPECT_LT((seen_pixel(camera, flight.motion(), Vec2(u, v)) - seen).norm(), 0.01) << readout_s;
      }
    }
    EXPECT_GT(most_moved, 1);
  }
}

double texture(const Vec2& p) {
  return 128 + 50 * std::sin(p.x() / 5) * std::cos(p.y() / 6) + 30 * std::sin((p.x() + p.y()) / 9);
}

TEST(RollingShutter, BringsAnImageToTheMiddleRow) {
  const Flight flight;
  const CameraModel camera = rolling_camera(0.06);
  std::vector<std::uint8_t> grey(640 * (480 + limits::max_rolling_rows));
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      grey[static_cast<std::size_t>(v) * 640 + static_cast<std::size_t>(u)] =
          static_cast<std::uint8_t>(texture(test::middle_pixel(camera, flight.motion(), Vec2(u, v))) + 0.5);
    }
  }
  double before = 0, after = 0;
  const auto rms = [&](double& sum) {
    for (int v = 12; v < 468; ++v) {
      for (int u = 12; u < 628; ++u) {
        const double off = grey[static_cast<std::size_t>(v) * 640 + static_cast<std::size_t>(u)] - texture(Vec2(u, v));
        sum += off * off;
      }
    }
    sum = std::sqrt(sum / (456 * 616));
  };
  rms(before);
  const Result<bool> moved = to_middle_row(camera, flight.motion(), 640, 480, grey);
  ASSERT_TRUE(moved.ok() && moved.value());
  rms(after);
  EXPECT_GT(before, 5);
  EXPECT_LT(after, 0.5) << "half a grey level is what rounding leaves twice";
}

TEST(RollingShutter, StaysAsItIsWithoutAReadoutAndWithoutMotion) {
  std::vector<std::uint8_t> grey(640 * (480 + limits::max_rolling_rows));
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = static_cast<std::uint8_t>(i * 37 % 251);
  const std::vector<std::uint8_t> was = grey;
  EXPECT_TRUE(to_middle_row(rolling_camera(0), Flight{}.motion(), 640, 480, grey).value());
  EXPECT_TRUE(to_middle_row(rolling_camera(0.03), ImageMotion{}, 640, 480, grey).value());
  EXPECT_TRUE(std::equal(grey.begin(), grey.begin() + 640 * 480, was.begin()));
}

TEST(RollingShutter, RefusesAMotionThatIsTooFastAndAnImageOfAnotherSize) {
  std::vector<std::uint8_t> grey(640 * (480 + limits::max_rolling_rows), 7);
  grey[1000] = 90;
  const std::vector<std::uint8_t> was = grey;
  ImageMotion fast;
  fast.m[5] = 16;  // 130 rows
  EXPECT_FALSE(to_middle_row(rolling_camera(0.03), fast, 640, 480, grey).value());
  fast.m[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(to_middle_row(rolling_camera(0.03), fast, 640, 480, grey).value());
  EXPECT_TRUE(std::equal(grey.begin(), grey.begin() + 640 * 480, was.begin()));
  EXPECT_TRUE(to_middle_row(rolling_camera(0.03), {}, 320, 240, grey).status().is(StatusCode::invalid_argument));
  EXPECT_TRUE(to_middle_row(rolling_camera(0.03), {}, 640, 480, std::span(grey).first(640 * 480))
                  .status()
                  .is(StatusCode::invalid_argument))
      << "there is no room to work in";
}

TEST(RollingShutter, ACameraWithAnImpossibleReadoutIsRefusedByName) {
  for (const double readout_s : {0.51, -0.6, std::numeric_limits<double>::infinity(), std::nan("")}) {
    CameraModel fisheye = rolling_camera(readout_s);
    fisheye.lens = Lens::fisheye;
    fisheye.p1 = fisheye.p2 = 0;
    for (const CameraModel& camera : {rolling_camera(readout_s), fisheye}) {
      const Status status = validate(camera);
      EXPECT_TRUE(status.is(StatusCode::invalid_argument)) << readout_s;
      EXPECT_EQ(status.a, static_cast<std::int64_t>(Argument::readout)) << readout_s;
    }
  }
  EXPECT_TRUE(validate(rolling_camera(-0.03)).ok());
}

}  // namespace
}  // namespace ilp
