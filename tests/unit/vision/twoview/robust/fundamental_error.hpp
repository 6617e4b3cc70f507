// How far a fundamental matrix is from the true epipolar geometry of a pair, in pixels.
#pragma once

#include <cmath>

#include "fsw/vision/twoview/solvers/decompose_essential.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"

namespace ilp::test {

inline Eigen::Vector4d gradient_by_match(const Mat3& f, const PointPair& p) {
  const Vec3 line_a = f.transpose() * Vec3(p.xb, p.yb, 1);
  const Vec3 line_b = f * Vec3(p.xa, p.ya, 1);
  return {line_a.x(), line_a.y(), line_b.x(), line_b.y()};
}

inline double algebraic_error(const Mat3& f, const PointPair& p) {
  return Vec3(p.xb, p.yb, 1).dot(f * Vec3(p.xa, p.ya, 1));
}

/// The match on the epipolar geometry `f` that is nearest to `p`, to second order.
inline PointPair moved_onto(const Mat3& f, PointPair p) {
  for (int step = 0; step < 2; ++step) {
    const Eigen::Vector4d gradient = gradient_by_match(f, p);
    const Eigen::Vector4d move = -algebraic_error(f, p) / gradient.squaredNorm() * gradient;
    p.xa += move[0];
    p.ya += move[1];
    p.xb += move[2];
    p.yb += move[3];
  }
  return p;
}

/// Root mean square of Sampson's distance from `f` of the true matches, moved onto the true geometry, px.
inline double error_of_fundamental(const PoseCase& pair, const Mat3& f) {
  const Mat3 k = intrinsics_of(pair.camera).normalised_from_pixel();
  const Mat3 truth = k.transpose() * essential_from_pose(pair.truth) * k;
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < pair.pairs.size(); ++i) {
    if (pair.inlier[i] == 0) continue;
    const PointPair exact = moved_onto(truth, pair.pairs[i]);
    const double error = algebraic_error(f, exact);
    sum += error * error / gradient_by_match(f, exact).squaredNorm();
    count += 1;
  }
  return std::sqrt(sum / count);
}

}  // namespace ilp::test
