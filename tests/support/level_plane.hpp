// What the overlap checker predicts over level ground.
#pragma once

#include "fsw/records/records.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {

/// Puts the homography of the plane z = 0 from the view before into the keyframe of a view with the same camera.
inline void put_level_plane(const View& before, const View& view, KeyframeRecord& keyframe) {
  const RigidTransform& a = before.cam_from_world;
  const RigidTransform step = compose(view.cam_from_world, inverse(a));
  const Vec3 normal = a.rotation * Vec3(0, 0, -1);
  Mat3 intrinsics = Mat3::Identity();
  intrinsics(0, 0) = view.camera.fx;
  intrinsics(1, 1) = view.camera.fy;
  intrinsics(0, 2) = view.camera.cx;
  intrinsics(1, 2) = view.camera.cy;
  const Mat3 turned_and_moved = step.rotation + step.translation * normal.transpose() / centre_of(a).z();
  Mat3 plane = intrinsics * turned_and_moved * intrinsics.inverse();
  plane /= plane(2, 2);
  for (int i = 0; i < 9; ++i) keyframe.plane_from_previous[i] = plane(i / 3, i % 3);
}

}  // namespace ilp::test
