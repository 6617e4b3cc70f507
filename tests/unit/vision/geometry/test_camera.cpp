// The camera model against its definition and its own inverse, and what validate() refuses.
#include "fsw/vision/geometry/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

CameraModel wide_angle() {
  CameraModel camera{640, 480, 500, 505, 322, 236, -0.28, 0.07, 6e-4, -3e-4};
  return camera;
}

TEST(Camera, DistortionFollowsItsDefinition) {
  CameraModel camera = wide_angle();
  // x = 0.5, y = 0.25: r2 = 0.3125; worked out by hand from the formulas of fsw/base/geometry.hpp.
  const Vec2 d = distort(camera, Vec2(0.5, 0.25));
  const double radial = 1 - 0.28 * 0.3125 + 0.07 * 0.3125 * 0.3125;
  EXPECT_NEAR(d.x(), 0.5 * radial + 2 * 6e-4 * 0.125 - 3e-4 * (0.3125 + 0.5), 1e-15);
  EXPECT_NEAR(d.y(), 0.25 * radial + 6e-4 * (0.3125 + 0.125) - 2 * 3e-4 * 0.125, 1e-15);
  const Vec2 pixel = pixel_from_normalised(camera, Vec2(0.5, 0.25));
  EXPECT_NEAR(pixel.x(), 500 * d.x() + 322, 1e-12);
  EXPECT_NEAR(pixel.y(), 505 * d.y() + 236, 1e-12);
}

TEST(Camera, UndistortionInvertsOverTheWholeImage) {
  const CameraModel camera = wide_angle();
  ASSERT_TRUE(validate(camera).ok());
  for (int y = 0; y < camera.height; y += 16) {
    for (int x = 0; x < camera.width; x += 16) {
      const Vec2 pixel(x, y);
      EXPECT_LT((pixel_from_normalised(camera, normalised_from_pixel(camera, pixel)) - pixel).norm(), 1e-9);
      EXPECT_LT((pixel_from_ideal(camera, ideal_from_pixel(camera, pixel)) - pixel).norm(), 1e-9);
    }
  }
}

TEST(Camera, WithoutDistortionIdealPixelsAreThePixels) {
  CameraModel camera = wide_angle();
  camera.k1 = camera.k2 = camera.p1 = camera.p2 = 0;
  const Vec2 pixel(17.25, 400.5);
  EXPECT_LT((ideal_from_pixel(camera, pixel) - pixel).norm(), 1e-12);
  EXPECT_EQ(normalised_from_ideal(camera, Vec2(322, 236)), Vec2(0, 0));
}

TEST(Camera, ANominalCameraHasTheFieldOfViewThatIsStated) {
  for (const double field : {0.05, 0.5, 1.0471975511965976, 2.8}) {
    const CameraModel camera = camera_of_field(640, 480, field);
    EXPECT_NEAR(2 * std::atan2(320, camera.fx), field, 1e-12);
    EXPECT_TRUE(validate(camera).ok()) << field;
    EXPECT_EQ(camera.fy, camera.fx);
    EXPECT_DOUBLE_EQ(camera.cx, 319.5);
    EXPECT_DOUBLE_EQ(camera.cy, 239.5);
    EXPECT_FALSE(camera.has_distortion());
    const double step = 1e-6;
    const double change = camera_of_field(640, 480, field + step).fx - camera_of_field(640, 480, field - step).fx;
    EXPECT_NEAR(focal_per_field(camera), change / (2 * step) / camera.fx, 1e-4 * std::fabs(focal_per_field(camera)));
  }
}

TEST(Camera, ValidateNamesTheFault) {
  const auto fault = [](auto change) {
    CameraModel camera = wide_angle();
    change(camera);
    const Status status = validate(camera);
    EXPECT_TRUE(status.is(StatusCode::invalid_argument));
    return static_cast<Argument>(status.a);
  };
  EXPECT_EQ(fault([](CameraModel& c) { c.width = 10; }), Argument::image_size);
  EXPECT_EQ(fault([](CameraModel& c) { c.fy = -500; }), Argument::focal_length);
  EXPECT_EQ(fault([](CameraModel& c) { c.cx = 5000; }), Argument::principal_point);
  EXPECT_EQ(fault([](CameraModel& c) { c.k1 = -2; }), Argument::distortion);  // folds the image over itself
  EXPECT_EQ(fault([](CameraModel& c) { c.p2 = std::numeric_limits<double>::quiet_NaN(); }), Argument::camera);
  EXPECT_EQ(fault([](CameraModel& c) { c.fx = std::numeric_limits<double>::infinity(); }), Argument::camera);
  CameraModel large = wide_angle();
  large.width = limits::max_image_width + 1;
  EXPECT_TRUE(validate(large).is(StatusCode::image_too_large));
  EXPECT_TRUE(validate_of_any_size(large).ok());
  large.fy = -500;
  EXPECT_TRUE(validate_of_any_size(large).is(StatusCode::invalid_argument));
}

TEST(Camera, AnImprobableOneIsDoubted) {
  CameraModel camera = camera_of_field(640, 480, 1.05);
  EXPECT_EQ(suspicion_about(camera), CameraSuspicion::none);
  CameraModel off = camera;
  off.fx = off.fy = 0.1 * camera.fx;
  EXPECT_EQ(suspicion_about(off), CameraSuspicion::field_of_view);
  off.fx = off.fy = 30 * camera.fx;
  EXPECT_EQ(suspicion_about(off), CameraSuspicion::field_of_view);
  for (const double field : {0.06, 0.2, 2.2})
    EXPECT_EQ(suspicion_about(camera_of_field(640, 480, field)), CameraSuspicion::none);
  off = camera;
  off.cx = 2 * camera.cx;  // of an image of twice the size
  EXPECT_EQ(suspicion_about(off), CameraSuspicion::principal_point);
  off = camera;
  off.cy = 0.3 * camera.height;
  EXPECT_EQ(suspicion_about(off), CameraSuspicion::principal_point);
}

}  // namespace
}  // namespace ilp
