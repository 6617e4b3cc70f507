#include "fsw/vision/twoview/refine/narrow_motion.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/twoview/solvers/decompose_essential.hpp"

namespace ilp {
namespace {

// Over a wider field, perspective moves the points of a body that is as deep as wide by a tenth of their parallax and
// more, so that the matches of a pair tell its turn. Flat ground has a rule of its own (plane_solutions.hpp).
constexpr double widest_spread_rad = 0.1;
constexpr double least_turn_rad = 0.005, largest_turn_rad = 1;

/// The mean ray of a view, and whether the others are near to it.
template <class Ray>
bool middle_of(const NormalisedPairs& pairs, const PairSelection& selection, const Ray& ray, Vec3& middle) {
  middle = Vec3::Zero();
  double spread2 = 0;
  const auto count = static_cast<double>(selection.count);
  for (std::size_t i = 0; i < selection.count; ++i) middle += ray(pairs.exact[selection.indices[i]]) / count;
  for (std::size_t i = 0; i < selection.count; ++i) {
    spread2 += (ray(pairs.exact[selection.indices[i]]) - middle).squaredNorm() / count;
  }
  return spread2 < widest_spread_rad * widest_spread_rad;
}

/// The shortest rotation that takes the optical axis to a direction in front of the camera.
Mat3 from_axis_to(const Vec3& direction) {
  const Vec3 unit = direction.normalized();
  const Mat3 turn = cross_matrix(Vec3(-unit.y(), unit.x(), 0));
  return Mat3::Identity() + turn + turn * turn / (1 + unit.z());
}

/// About z, x to the direction (x, y) of unit length.
Mat3 to_axis(double x, double y) {
  Mat3 rotation;
  rotation << x, -y, 0, y, x, 0, 0, 0, 1;
  return rotation;
}

}  // namespace

Mat3 NarrowMotion::rotation() const {
  return frame_b * rotation_from_vector(Vec3(turn_rad, 0, 0)) * frame_a.transpose();
}

Vec3 NarrowMotion::translation() const {
  return middle_b + offset * frame_b.col(0) - depth_ratio * (rotation() * middle_a);
}

bool narrow_motion(const NormalisedPairs& pairs, const PairSelection& selection, const RigidTransform& b_from_a,
                   NarrowMotion& motion) {
  if (selection.count == 0) return false;
  motion = {};
  if (!middle_of(
          pairs, selection, [](const NormalisedPair& pair) { return pair.ray_a(); }, motion.middle_a) ||
      !middle_of(
          pairs, selection, [](const NormalisedPair& pair) { return pair.ray_b(); }, motion.middle_b)) {
    return false;
  }
  const Mat3 along_a = from_axis_to(motion.middle_a);
  const Mat3 along_b = from_axis_to(motion.middle_b);
  // Near the middle the epipolar constraint is linear: the coordinate along the axis of the turn is the same in both
  // images, in proportion to the depths.
  const Mat3 e = along_b.transpose() * essential_from_pose(b_from_a) * along_a;
  const double by_a = std::sqrt(e(2, 0) * e(2, 0) + e(2, 1) * e(2, 1));
  const double by_b = std::sqrt(e(0, 2) * e(0, 2) + e(1, 2) * e(1, 2));
  if (!(by_a > 0.1 * by_b) || !(by_b > 0.1 * by_a)) return false;
  motion.frame_a = along_a * to_axis(-e(2, 0) / by_a, -e(2, 1) / by_a);
  motion.frame_b = along_b * to_axis(e(0, 2) / by_b, e(1, 2) / by_b);
  motion.depth_ratio = by_a / by_b * motion.middle_b.norm() / motion.middle_a.norm();
  const Mat3 turn = motion.frame_b.transpose() * b_from_a.rotation * motion.frame_a;
  const double angle = det_atan2(turn(2, 1) - turn(1, 2), turn(1, 1) + turn(2, 2));
  const double bounded = std::clamp(std::fabs(angle), least_turn_rad, largest_turn_rad);
  motion.turn_rad = angle < 0 ? -bounded : bounded;
  return true;
}

RigidTransform pose_of(const NarrowMotion& motion) {
  return {motion.rotation(), motion.translation().normalized()};
}

}  // namespace ilp
