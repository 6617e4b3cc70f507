#include "fsw/vision/twoview/plane_solutions.hpp"

#include <algorithm>

#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/solvers/homography.hpp"

namespace ilp {
namespace {

constexpr double min_share_visible = 0.9;   // of the matches; a few may be false
constexpr double same_direction = 0.99985;  // cosine of one degree

std::uint32_t count_visible(const NormalisedPairs& pairs, const PlaneMotion& motion, double threshold_px,
                            std::uint32_t& on_plane) {
  const RigidTransform& pose = motion.b_from_a;
  const Mat3 homography = pose.rotation + pose.translation * motion.plane.transpose();
  std::uint32_t visible = 0;
  on_plane = 0;
  for (const NormalisedPair& pair : pairs.exact) {
    // Either sign, because the transfer error alone does not distinguish front and back.
    const bool in_front_of_b = (homography * pair.ray_a()).z() > 0;
    const Mat3 towards = in_front_of_b ? homography : Mat3(-homography);
    if (!(transfer_squared(towards, pair, pairs.scale) < threshold_px * threshold_px)) continue;
    ++on_plane;
    // X_a = ray_a / (plane . ray_a), X_b = H X_a.
    visible += in_front_of_b && motion.plane.dot(pair.ray_a()) > 0 ? 1U : 0U;
  }
  return visible;
}

double difference(const RigidTransform& p, const RigidTransform& q) {
  return (p.rotation - q.rotation).squaredNorm() + (p.translation - q.translation).squaredNorm();
}

}  // namespace

void find_plane_solutions(const NormalisedPairs& pairs, const Mat3& homography, const RigidTransform& pose,
                          double threshold_px, PlaneSolutions& solutions) {
  solutions = {};
  PlaneMotion motions[4];
  const std::size_t count = decompose_homography(homography, motions);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t on_plane = 0;
    const std::uint32_t visible = count_visible(pairs, motions[i], threshold_px, on_plane);
    // The negated motion of the same plane sees the same points behind it, so that at most two of four pass.
    if (visible == 0 || visible < min_share_visible * on_plane || solutions.count == 2) continue;
    solutions.solution[solutions.count++] = {motions[i], visible};
  }
  if (solutions.count < 2) return;
  PlaneSolution* const s = solutions.solution;
  if (difference(s[1].motion.b_from_a, pose) < difference(s[0].motion.b_from_a, pose)) std::swap(s[0], s[1]);
  if (s[0].motion.b_from_a.translation.dot(s[1].motion.b_from_a.translation) > same_direction) solutions.count = 1;
}

}  // namespace ilp
