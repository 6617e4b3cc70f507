// Lenses beyond four coefficients: against OpenCV's projections, their own inverse, and differences.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

CameraModel pinhole() {
  CameraModel c{640, 480, 500, 505, 322, 236};
  return c;
}

CameraModel five() {
  CameraModel c = pinhole();
  c.k1 = -0.28;
  c.k2 = 0.07;
  c.p1 = 6e-4;
  c.p2 = -3e-4;
  c.k3 = -0.02;
  return c;
}

CameraModel eight() {
  CameraModel c = five();
  c.k1 = 0.35;
  c.k2 = -0.11;
  c.k3 = 0.015;
  c.k4 = 0.61;
  c.k5 = -0.08;
  c.k6 = 0.03;
  return c;
}

CameraModel fisheye() {
  CameraModel c = pinhole();
  c.lens = Lens::fisheye;
  c.k1 = -0.02;
  c.k2 = 0.013;
  c.k3 = -0.006;
  c.k4 = 0.0011;
  return c;
}

/// With a corner at 71 degrees.
CameraModel wide_fisheye() {
  CameraModel c = fisheye();
  c.fx = 330;
  c.fy = 332;
  return c;
}

const CameraModel lenses[] = {five(), eight(), fisheye(), wide_fisheye()};

struct Projected {
  double x, y, u, v;
};

void expect_projections(const CameraModel& camera, const std::vector<Projected>& points) {
  for (const Projected& p : points) {
    const Vec2 pixel = pixel_from_normalised(camera, Vec2(p.x, p.y));
    EXPECT_NEAR(pixel.x(), p.u, 1e-9) << p.x << " " << p.y;
    EXPECT_NEAR(pixel.y(), p.v, 1e-9) << p.x << " " << p.y;
  }
}

// OpenCV 4.6, projectPoints and fisheye::projectPoints.
TEST(Lenses, ProjectAsOpenCvDoes) {
  expect_projections(five(), {{-1.1, -0.7, -23.578, 14.56659},
                              {-0.3, 0.6, 188.844625, 504.9738575},
                              {0, 0.2, 321.994, 335.91634272},
                              {0.9, -0.7, 640.846, -14.23053}});
  expect_projections(eight(), {{-1.1, -0.7, -58.5272132460232, -7.89622251358037},
                               {-0.3, 0.6, 186.599864528309, 509.508273652817},
                               {0, 0.2, 321.994, 336.006025302032},
                               {0.9, -0.7, 661.104723323529, -30.144882655261}});
  expect_projections(fisheye(), {{-2.64, -1.68, -201.602343719688, -100.533506372563},
                                 {-0.72, 1.44, 97.795057860681, 688.893983121424},
                                 {0, 0.48, 322, 461.199706566649},
                                 {2.16, -1.68, 796.276519461199, -136.570554732298}});
  EXPECT_EQ(pixel_from_normalised(fisheye(), Vec2(0, 0)), Vec2(322, 236));
}

TEST(Lenses, AreInvertedOverTheWholeImage) {
  for (const CameraModel& camera : lenses) {
    ASSERT_TRUE(validate(camera).ok()) << camera.fx << " " << camera.k4;
    std::vector<double> x, y;
    std::vector<Vec2> one_by_one;
    for (int v = 0; v < camera.height; v += 13) {
      for (int u = 0; u < camera.width; u += 13) {
        const Vec2 pixel(u, v), distorted = normalised_from_ideal(camera, pixel);
        EXPECT_LT((pixel_from_normalised(camera, normalised_from_pixel(camera, pixel)) - pixel).norm(), 1e-9);
        EXPECT_LT((pixel_from_ideal(camera, ideal_from_pixel(camera, pixel)) - pixel).norm(), 1e-9);
        one_by_one.push_back(undistort(camera, distorted));
        x.push_back(distorted.x());
        y.push_back(distorted.y());
      }
    }
    undistort(camera, static_cast<std::int32_t>(x.size()), x.data(), y.data());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(Vec2(x[i], y[i]), one_by_one[i]);
  }
}

TEST(Lenses, DerivativesAreThoseOfDifferences) {
  std::vector<CameraModel> all(std::begin(lenses), std::end(lenses));
  all.push_back(five());
  all.back().k3 = 0;
  constexpr double step = 1e-6;
  for (const CameraModel& camera : all) {
    for (const Vec2& at : {Vec2(0, 0), Vec2(1e-12, 0), Vec2(0.3, -0.2), Vec2(-0.8, 0.5)}) {
      const DistortionJacobian j = distortion_jacobian(camera, at.x(), at.y());
      const Vec2 by_x = (distort(camera, at + Vec2(step, 0)) - distort(camera, at - Vec2(step, 0))) / (2 * step);
      const Vec2 by_y = (distort(camera, at + Vec2(0, step)) - distort(camera, at - Vec2(0, step))) / (2 * step);
      EXPECT_LT((Vec2(j.a, j.c) - by_x).norm() + (Vec2(j.b, j.d) - by_y).norm(), 1e-8) << at.transpose();
      const auto by = pixel_by_intrinsics(camera, at);
      for (std::size_t i = 0; i < intrinsic_count; ++i) {
        const auto moved = [&](double by_how_much) {
          CameraModel c = camera;
          if (i == 0) {
            c.fy *= (c.fx + by_how_much) / c.fx;
            c.fx += by_how_much;
          } else {
            double* const members[] = {&c.cx, &c.cy, &c.k1, &c.k2, &c.p1, &c.p2};
            const bool is_tangential = i >= 5;
            if (!(is_tangential && c.lens == Lens::fisheye)) *members[i - 1] += by_how_much;
          }
          return pixel_from_normalised(c, at);
        };
        const Vec2 difference = (moved(step) - moved(-step)) / (2 * step);
        EXPECT_LT((by.col(static_cast<int>(i)) - difference).norm(), 2e-6) << i << " at " << at.transpose();
      }
    }
  }
}

TEST(Lenses, OfAnotherFocalLengthBendTheSamePixels) {
  for (const CameraModel& camera : {five(), eight()}) {
    const CameraModel longer = with_focal_length(camera, 1.25);
    for (const Vec2& ideal : {Vec2(20, 30), Vec2(500, 100), Vec2(630, 470)})
      EXPECT_LT((pixel_from_ideal(longer, ideal) - pixel_from_ideal(camera, ideal)).norm(), 1e-9);
  }
}

TEST(Lenses, ThatCannotBeInvertedAreRefused) {
  const auto fault = [](CameraModel camera) { return static_cast<Argument>(validate(camera).a); };
  CameraModel c = eight();
  c.k4 = -4;  // 1 / 0 within the image
  EXPECT_EQ(fault(c), Argument::distortion);
  c = five();
  c.k3 = -3;
  EXPECT_EQ(fault(c), Argument::distortion);
  c.k3 = NAN;
  EXPECT_EQ(fault(c), Argument::camera);
  c = fisheye();
  c.k2 = -1;  // turns back before the corner
  EXPECT_EQ(fault(c), Argument::distortion);
  c = fisheye();
  c.fx = c.fy = 200;  // half a diagonal of 2 rad
  EXPECT_EQ(fault(c), Argument::view_angle);
  // A corner at 74 and at 76 degrees.
  c = pinhole();
  c.lens = Lens::fisheye;
  c.cx = 319.5;
  c.cy = 239.5;
  c.fx = c.fy = 400 / (74 * M_PI / 180);
  EXPECT_TRUE(validate(c).ok());
  c.fx = c.fy = 400 / (76 * M_PI / 180);
  EXPECT_EQ(fault(c), Argument::view_angle);
}

}  // namespace
}  // namespace ilp
