// The residual vertical disparity distinguishes poses that fit the images from wrong ones.
#include <gtest/gtest.h>

#include <cstdio>

#include "fsw/vision/stereo/rectify/rectification_residual.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"
#include "tests/unit/vision/stereo/reconstruct.hpp"

namespace ilp::test {
namespace {

double hill(double x, double y) {
  return 8 * std::exp(-((x - 12) * (x - 12) + y * y) / 500) + 0.03 * x - 0.02 * y;
}

/// The residual of two views of which the second is assumed to be turned by `error` (rotation vector, camera frame).
VerticalResidual residual_of(const Vec3& baseline, const Vec3& error) {
  static const CameraModel camera = distorting_camera();
  const RigidTransform pose_a = looking_down({0, 0, 100});
  const RigidTransform pose_b = looking_down(Vec3(0, 0, 100) + baseline, {0.02, 0, 0.1});
  const View a = render_view(camera, pose_a, hill, 3, 1.0, 1);
  const View b = render_view(camera, pose_b, hill, 3, 1.0, 2);
  RigidTransform believed = pose_b;
  believed.rotation = rotation_from_vector(error) * pose_b.rotation;
  believed.translation = -(believed.rotation * centre_of(pose_b));
  RectificationPlan plan;
  EXPECT_TRUE(plan_panels(camera, pose_a, believed, {80, 125}, {}, plan).ok());
  VerticalResidual residual;
  for (std::size_t i = 0; i < plan.count; ++i) {
    const RectifiedPanel& panel = plan.panels[i];
    const Rectified r = resample(panel.pair, a, b);
    Disparities d = match(r, panel.range);
    add_vertical_residuals(r.left.view(), r.right.view(), std::as_const(r.right_valid).view(), d.view(), residual);
  }
  std::printf("baseline (%g %g %g), error (%g %g %g): median %.3f px of %u\n", baseline.x(), baseline.y(), baseline.z(),
              error.x(), error.y(), error.z(), residual.median_px(), residual.count);
  return residual;
}

TEST(RectificationResidual, IsSmallWithTheTruePoses) {
  for (const Vec3& baseline : {Vec3(20, 0, 0), Vec3(3, 18, 1), Vec3(0, 0, -18), Vec3(10, 3, -15)}) {
    const VerticalResidual residual = residual_of(baseline, Vec3::Zero());
    EXPECT_GT(residual.count, min_vertical_residuals);
    EXPECT_LT(residual.median_px(), 0.3);
  }
}

TEST(RectificationResidual, IsTheVerticalShiftOfASlightlyWrongPose) {
  // About the baseline: rows move by half a pixel of the 305 px focal length.
  const VerticalResidual residual = residual_of({20, 0, 0}, {0.5 / 305, 0, 0});
  EXPECT_NEAR(residual.median_px(), 0.5, 0.12);
}

TEST(RectificationResidual, ExceedsItsBoundWithAWrongPose) {
  for (const Vec3& error : {Vec3(0.006, 0, 0), Vec3(0.02, 0, 0), Vec3(0, 0, 0.05)}) {
    const VerticalResidual sideways = residual_of({20, 0, 0}, error);
    EXPECT_GT(sideways.median_px(), max_vertical_residual_px);
    const VerticalResidual descent = residual_of({0, 0, -18}, error);
    if (descent.count >= min_vertical_residuals && error.z() == 0) {
      EXPECT_GT(descent.median_px(), max_vertical_residual_px);
    }
  }
}

}  // namespace
}  // namespace ilp::test
