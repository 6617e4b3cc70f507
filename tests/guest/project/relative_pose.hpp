// How the second of two images was taken, seen from the first, and the points that both show.
#pragma once

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/solvers/triangulation.hpp"
#include "fsw/vision/twoview/two_view.hpp"
#include "matching.hpp"

struct RelativePose {
  ilp::RigidTransform b_from_a;   ///< one unit from camera to camera
  std::vector<ilp::Vec3> points;  ///< in the frame of camera a
};

inline RelativePose relative_pose(ilp::GrayView a, ilp::GrayView b) {
  ilp::Corners corners_a = corners_of(a), corners_b = corners_of(b);
  ilp::PointPairs pairs;
  for (const ilp::Match& m : matches_of(a, corners_a, b, corners_b)) {
    const ilp::Vec2 in_a = ilp::ideal_from_pixel(camera, {corners_a[m.a].x, corners_a[m.a].y});
    const ilp::Vec2 in_b = ilp::ideal_from_pixel(camera, {m.xb, m.yb});
    (void)pairs.push_back({in_a.x(), in_a.y(), in_b.x(), in_b.y(), m.score});
  }
  const auto workspace = std::make_unique<ilp::TwoViewWorkspace>();
  ilp::InlierMask inliers;
  ilp::TwoViewResult result;
  check(ilp::estimate_two_view(pairs, camera, camera, {}, *workspace, inliers, result), "relative pose");
  RelativePose pose{result.b_from_a, {}};
  const auto ray = [](double x, double y) {
    return ilp::Vec2((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const ilp::RayView views[] = {{ray(pairs[i].xa, pairs[i].ya), {}}, {ray(pairs[i].xb, pairs[i].yb), pose.b_from_a}};
    ilp::TriangulatedPoint point;
    if (inliers[i] != 0 && ilp::triangulate(views, 2, point).ok()) pose.points.push_back(point.position);
  }
  return pose;
}
