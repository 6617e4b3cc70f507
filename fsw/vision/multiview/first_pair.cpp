#include "fsw/vision/multiview/first_pair.hpp"

#include <cmath>
#include <limits>

namespace ilp {
namespace {

// The odds assume exact planes. Since the planes are as noisy as the third view, a view from the place of a or b
// reaches odds of 6 by chance; others have thousands.
constexpr double min_log_odds = 25;
// Excess of the worse plane over a free homography, px^2 per match: both explain the view.
constexpr double explained = 0.02;

/// Cosine of the largest angle between two motions that the adjustment makes one: 15 degrees.
constexpr double same_motion_cosine = 0.966;

/// plane . X = 1 in frame a says (R plane) . X = 1 + (R plane) . t in frame b.
void put_plane(const RigidTransform& b_from_a, const Vec3& plane_in_a, double (&plane_in_b)[3]) {
  const Vec3 turned = b_from_a.rotation * plane_in_a;
  const Vec3 plane = turned / (1 + turned.dot(b_from_a.translation));
  for (int i = 0; i < 3; ++i) plane_in_b[i] = plane[i];
}

void put_camera(const RigidTransform& from_first, FirstPair::RivalCamera& camera) {
  for (int i = 0; i < 9; ++i) camera.rotation[i] = from_first.rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) camera.translation[i] = from_first.translation[i];
}

Vec3 plane_of(const FirstPair& pair, std::size_t s) {
  return {pair.plane[s][0], pair.plane[s][1], pair.plane[s][2]};
}

}  // namespace

double expected_depth_error(const TwoViewResult& pair, double focal_px) {
  if (pair.verdict != TwoViewVerdict::ok && pair.verdict != TwoViewVerdict::planar) {
    return std::numeric_limits<double>::infinity();
  }
  const double of_match = pair.rms_px / pair.median_parallax_px;
  // A turn by the parallax hides it.
  const double of_turn = pair.sigma_rotation_rad * focal_px / pair.median_parallax_px;
  const double of_direction = pair.sigma_direction_rad;
  return std::sqrt(of_match * of_match + of_turn * of_turn + of_direction * of_direction);
}

void remember_rival(const PlaneSolutions& planes, FirstPair& pair) {
  pair.ambiguous = false;
  if (planes.count != 2) return;
  const RigidTransform& rival = planes.solution[1].motion.b_from_a;
  const Vec3& taken = planes.solution[0].motion.b_from_a.translation;
  if (taken.dot(rival.translation) > same_motion_cosine * taken.norm() * rival.translation.norm()) return;
  pair.ambiguous = true;
  put_camera(rival, pair.rival[0]);
  for (int s = 0; s < 2; ++s) {
    const PlaneMotion& motion = planes.solution[s].motion;
    put_plane(motion.b_from_a, motion.plane, pair.plane[s]);
  }
}

void keep_open(const ThirdViewChoice& third, FirstPair& pair) {
  ++pair.undecided;
  put_camera(compose(third.c_from_a[1], rival_camera(pair, 0)), pair.rival[1]);
  for (std::size_t s = 0; s < 2; ++s) put_plane(third.c_from_a[s], plane_of(pair, s), pair.plane[s]);
}

RigidTransform rival_camera(const FirstPair& pair, std::size_t index) {
  RigidTransform camera;
  for (int i = 0; i < 9; ++i) camera.rotation(i / 3, i % 3) = pair.rival[index].rotation[i];
  for (int i = 0; i < 3; ++i) camera.translation[i] = pair.rival[index].translation[i];
  return camera;
}

Status choose_motion(const FirstPair& pair, const PointPairs& pairs, const CameraModel& camera,
                     const RansacParams& params, TwoViewWorkspace& workspace, MotionChoice& choice,
                     ThirdViewChoice& third) {
  choice = MotionChoice::taken;
  PlaneSolutions solutions;
  solutions.count = 2;
  for (std::size_t s = 0; s < 2; ++s) solutions.solution[s].motion.plane = plane_of(pair, s);
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
