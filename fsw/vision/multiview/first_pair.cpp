#include "fsw/vision/multiview/first_pair.hpp"

namespace ilp {
namespace {

// The odds take the planes for exact. As these are as noisy as the third view, a view from where a or b stood reaches
// odds of 6 by chance; others have thousands.
constexpr double min_log_odds = 25;
// Of the worse plane over a free homography, px^2 per match: both explain the view.
constexpr double explained = 0.02;

/// Of the angle between two motions that the adjustment makes one: 15 degrees.
constexpr double same_motion_cosine = 0.966;

/// plane . X = 1 in frame a says (R plane) . X = 1 + (R plane) . t in frame b.
Vec3 plane_in_b(const PlaneMotion& motion) {
  const Vec3 turned = motion.b_from_a.rotation * motion.plane;
  return turned / (1 + turned.dot(motion.b_from_a.translation));
}

}  // namespace

void remember_rival(const PlaneSolutions& planes, FirstPair& pair) {
  pair.ambiguous = false;
  if (planes.count != 2) return;
  const RigidTransform& rival = planes.solution[1].motion.b_from_a;
  const Vec3& taken = planes.solution[0].motion.b_from_a.translation;
  if (taken.dot(rival.translation) > same_motion_cosine * taken.norm() * rival.translation.norm()) return;
  pair.ambiguous = true;
  for (int i = 0; i < 9; ++i) pair.rival_rotation[i] = rival.rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) pair.rival_translation[i] = rival.translation[i];
  for (int s = 0; s < 2; ++s) {
    const Vec3 plane = plane_in_b(planes.solution[s].motion);
    for (int i = 0; i < 3; ++i) pair.plane[s][i] = plane[i];
  }
}

RigidTransform rival_motion(const FirstPair& pair) {
  RigidTransform motion;
  for (int i = 0; i < 9; ++i) motion.rotation(i / 3, i % 3) = pair.rival_rotation[i];
  for (int i = 0; i < 3; ++i) motion.translation[i] = pair.rival_translation[i];
  return motion;
}

Status choose_motion(const FirstPair& pair, const PointPairs& pairs, const CameraModel& camera,
                     const RansacParams& params, TwoViewWorkspace& workspace, MotionChoice& choice) {
  choice = MotionChoice::taken;
  PlaneSolutions solutions;
  solutions.count = 2;
  for (int s = 0; s < 2; ++s) {
    for (int i = 0; i < 3; ++i) solutions.solution[s].motion.plane[i] = pair.plane[s][i];
  }
  ThirdViewChoice third;
  ILP_TRY(choose_by_third_view(solutions, pairs, camera, camera, params, workspace, third));
  if (third.decided && third.log_odds > min_log_odds) {
    if (third.chosen == 1) choice = MotionChoice::rival;
    return {};
  }
  const double worse = third.excess_px2[0] > third.excess_px2[1] ? third.excess_px2[0] : third.excess_px2[1];
  if (third.matches > 0 && worse < explained * third.matches) choice = MotionChoice::open;
  return {};
}

}  // namespace ilp
