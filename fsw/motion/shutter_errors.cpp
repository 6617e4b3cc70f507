#include "fsw/motion/shutter_errors.hpp"

#include <cmath>

#include "fsw/motion/keyframe_motion.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

Status find_baseline_errors(Reader<ShutterRecord, StripRecord, PoseRecord> store, const CameraRecord& camera,
                            const PoseRecord& pose, BaselineErrors& errors) {
  StripRecord strip;
  ILP_TAKE(const bool known, find<StripRecord>(store, pose.strip_id, strip));
  ShutterRecord first, second;
  ILP_TAKE(const bool has_first, find<ShutterRecord>(store, strip.first_keyframe_id, first));
  if (!known || !has_first) return {};
  errors.first = shutter_error_rad(camera, first);
  ILP_TAKE(const bool has_second, find<ShutterRecord>(store, strip.first_keyframe_id + 1, second));
  PoseRecord end;
  ILP_TAKE(const bool posed, find<PoseRecord>(store, strip.first_keyframe_id + 1, end));
  const double baseline = vector_of(posed ? end.centre : pose.centre).norm();
  if (!has_second || !(baseline > 0)) return {};
  errors.length = Vec2(errors.first, shutter_error_rad(camera, second)).norm() / baseline;
  return {};
}

void add_errors(double own_rad, const BaselineErrors& baseline, PoseRecord& pose) {
  // Lower triangle: rotation, then centre.
  constexpr int diagonal[6] = {0, 2, 5, 9, 14, 20};
  const double depth = pose.ground_distance > 0 ? pose.ground_distance : 0.5 * (pose.min_depth + pose.max_depth);
  const double turned = own_rad * own_rad, squared = depth * depth;
  const double displaced = (turned + baseline.first * baseline.first) * squared,
               scaled = baseline.length * baseline.length * squared;
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
