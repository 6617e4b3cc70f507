#include "fsw/motion/shutter_errors.hpp"

#include <cmath>

#include "fsw/motion/keyframe_motion.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {
namespace {

Result<double> shutter_error_of(Reader<ShutterRecord> store, const CameraRecord& camera, std::int64_t keyframe_id) {
  ShutterRecord shutter;
  ILP_TAKE(const bool recorded, find<ShutterRecord>(store, keyframe_id, shutter));
  static_cast<void>(recorded);
  return shutter_error_rad(camera, shutter);
}

}  // namespace

Result<ShutterErrors> shutter_errors(Reader<ShutterRecord, StripRecord, PoseRecord> store, const CameraRecord& camera,
                                     const PoseRecord& pose) {
  ShutterErrors errors;
  ILP_TAKE(errors.own, shutter_error_of(store, camera, pose.id));
  StripRecord strip;
  ILP_TAKE(const bool known, find<StripRecord>(store, pose.strip_id, strip));
  if (!known) return errors;
  ILP_TAKE(errors.first, shutter_error_of(store, camera, strip.first_keyframe_id));
  PoseRecord second;
  ILP_TAKE(const bool posed, find<PoseRecord>(store, strip.first_keyframe_id + 1, second));
  const Vec3 baseline = vector_of(posed ? second.centre : pose.centre);
  if (!(baseline.squaredNorm() > 0)) return errors;
  ILP_TAKE(const double of_second, shutter_error_of(store, camera, strip.first_keyframe_id + 1));
  errors.length = Vec2(errors.first, of_second).norm() / baseline.norm();
  return errors;
}

void add_errors(const ShutterErrors& errors, PoseRecord& pose) {
  // Lower triangle: rotation, then centre.
  constexpr int diagonal[6] = {0, 2, 5, 9, 14, 20};
  const double depth = pose.ground_distance > 0 ? pose.ground_distance : 0.5 * (pose.min_depth + pose.max_depth);
  const double turned = errors.own * errors.own, squared = depth * depth;
  const double displaced = (turned + errors.first * errors.first) * squared,
               scaled = errors.length * errors.length * squared;
  for (int i = 0; i < 6; ++i) {
    if (pose.covariance[diagonal[i]] > 0) pose.covariance[diagonal[i]] += i < 3 ? turned : displaced;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i && pose.covariance[diagonal[3 + i]] > 0; ++j) {
      pose.covariance[diagonal[3 + i] - i + j] += scaled * pose.centre[i] * pose.centre[j];
    }
    const double own = displaced + scaled * pose.centre[i] * pose.centre[i];
    if (pose.sigma[i] > 0) pose.sigma[i] = std::sqrt(pose.sigma[i] * pose.sigma[i] + own);
  }
}

}  // namespace ilp
