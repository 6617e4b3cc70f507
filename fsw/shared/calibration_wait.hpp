// How long a keyframe waits for the intrinsics of a camera that is not known (decisions.md, 6). The answer follows from
// records alone, not from when it is asked: a power cut does not change which keyframes get a pose.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

enum class CalibrationWait : std::uint8_t {
  none,    ///< the camera is frozen
  wait,    ///< it may be soon
  in_vain  ///< too many keyframes, or half the storage budget, passed without a calibration, or the flight ended
};

/// `newest` has been tried without success: has `oldest` waited long enough?
[[nodiscard]] bool waited_out(const MissionParameters& mission, const CameraRecord& camera,
                              const KeyframeRecord& oldest, const KeyframeRecord& newest);

/// The flight has ended, and keyframe `looked_at` is its last one.
Result<bool> flight_has_ended(Reader<StripRecord> store, std::int64_t looked_at);

using CalibrationWaitStore = Reader<CameraRecord, CalibrationRecord, KeyframeRecord, StripRecord>;
Result<CalibrationWait> calibration_wait(CalibrationWaitStore store, const MissionParameters& mission,
                                         const KeyframeRecord& keyframe);

/// The keyframe was processed without intrinsics.
[[nodiscard]] bool waited_in_vain(const PoseRecord& pose);
/// Id of the camera record for everything derived from this keyframe.
[[nodiscard]] std::int64_t camera_id_of(const PoseRecord& pose);

}  // namespace ilp
