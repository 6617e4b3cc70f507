#include "fsw/shared/calibration_wait.hpp"

#include "fsw/shared/camera_on_record.hpp"
#include "fsw/vision/calibration/self_calibration.hpp"
#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

bool waited_out(const MissionParameters& mission, const CameraRecord& camera, const KeyframeRecord& oldest,
                const KeyframeRecord& newest) {
  const double held_bytes = static_cast<double>(newest.frame_id - oldest.frame_id) * camera.width * camera.height;
  return static_cast<double>(newest.id - oldest.id) >= mission.calibration_patience_keyframes ||
         held_bytes > 0.5 * mission.storage_budget_mib * 1048576;
}

Result<bool> flight_has_ended(Reader<StripRecord> store, std::int64_t looked_at) {
  StripRecord strip;
  ILP_TRY(last(store, strip));
  return strip.end == StripEnd::end_of_flight && strip.last_keyframe_id == looked_at;
}

Result<CalibrationWait> calibration_wait(CalibrationWaitStore store, const MissionParameters& mission,
                                         const KeyframeRecord& keyframe) {
  CameraRecord camera;
  ILP_TRY(get_camera(store, camera_id, camera));
  CalibrationRecord said;
  const Status found = last(store, said);
  // The latest record is damaged. The camera itself shows whether it was found.
  if (is_gone(found)) return camera.frozen ? CalibrationWait::none : CalibrationWait::wait;
  ILP_TRY(found);
  const bool calibrated = said.verdict == CalibrationVerdict::ok || camera.frozen;
  const std::int64_t newest_in_vain = calibrated ? said.id - 1 : said.id;
  if (newest_in_vain > keyframe.id) {
    KeyframeRecord newest;
    ILP_TRY(get(store, newest_in_vain, newest));
    if (waited_out(mission, camera, keyframe, newest)) return CalibrationWait::in_vain;
  }
  if (calibrated) return CalibrationWait::none;
  // The calibrator freezes the nominal camera then.
  if (mission.calibration_fallback == CalibrationFallback::nominal) return CalibrationWait::wait;
  ILP_TAKE(const bool ended, flight_has_ended(store, said.id));
  return ended ? CalibrationWait::in_vain : CalibrationWait::wait;
}

bool waited_in_vain(const PoseRecord& pose) {
  return pose.verdict == PoseVerdict::not_calibrated;
}

std::int64_t camera_id_of(const PoseRecord& pose) {
  return waited_in_vain(pose) ? nominal_camera_id : camera_id;
}

}  // namespace ilp
