// Calibrates an unknown camera from the keyframes and freezes it, then checks strips against the frozen one (paper
// 3.2.1; decisions.md, 6).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/motion/keyframe_features.hpp"
#include "fsw/motion/measured_focal.hpp"
#include "fsw/motion/strip_check.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "fsw/vision/calibration/self_calibration.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// While the camera is not frozen, each keyframe gets corners, matches to the previous keyframe, the steps of
/// SelfCalibration and a record of their result. On ok the camera is replaced and frozen in the same transaction.
/// Events report a change of the reason to wait, and the time when keyframes begin to wait in vain. If the mission says
/// so (CalibrationFallback), the nominal camera is frozen then, or when the flight ends, with the error of its focal
/// length. If the vehicle measures its attitude, the camera may also follow from that and from the plane of the ground;
/// heights and places make it surer (measured_focal.hpp).
///
/// After that, StripCheck compares the images of each strip with the camera. A keyframe that cannot be read shares
/// nothing with its neighbours.
class CameraCalibrator final : public StageComponent<ComponentId::camera_calibrator> {
 public:
  /// The first form is for the search for the camera, the second for the time after it is frozen.
  static const CheckpointForm checkpoint;
  static const CheckpointForm second_checkpoint;
  using Scratch = StepScratch<FeatureScratch>;

  CameraCalibrator(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override;

 private:
  enum class Phase : std::uint8_t { idle, load, detect, begin_match, match, relate, calibrate, measure, record };

  struct Wiring {
    Tables store;
    const MissionParameters& mission;
    Scratch scratch;
  };
  struct CalibratingState {
    CalibrationState calibration;
    std::int64_t strip_id = 0;  ///< strip of the set's keyframes
    bool reason_told = false;
    std::uint8_t reason = 0;  ///< reason in the latest event
    bool overdue_told = false;
    MeasuredFocal measured;
  };
  /// A checkpoint holds one of them.
  struct State {
    CalibratingState calibrating;
    StripCheckState checking;
  };
  struct Work {
    CameraRecord camera;
    // The keyframe or the strip at work; a restart drops it.
    Phase phase = Phase::idle;
    bool keeps = false;  ///< the search for corners or matches goes on in the step's memory
    Status event;
    Patience patience;
    KeyframeRecord keyframe;
    StripCheckWork check;
  };
  struct Workspace {
    CalibrationWorkspace calibration;
    NavigationRecord navigation;  ///< what the vehicle measured at the keyframe
    KeyframeImages images;
    Corners corners;
    Matches matches;
    StripCheckWorkspace check;
  };

  StepResult calibrate();
  Result<bool> advance();
  Result<bool> pick_keyframe();
  Status load();
  Status detect();
  Status begin_match();
  Status match();
  Status relate();
  Status record();
  Status record_waiting(const CalibrationRecord& said, bool overdue, std::int64_t oldest_id);
  Status freeze(const CameraRecord& frozen, const CalibrationRecord* said, const Status& event);
  void measure();
  [[nodiscard]] CameraRecord found_camera() const;
  [[nodiscard]] CameraRecord nominal_camera() const;
  Status freeze_found(const CameraRecord& found, const CalibrationRecord* said, std::int64_t keyframe_id);
  Status freeze_nominal(const CalibrationRecord* said);
  Result<bool> end_flight();
  void tell_why(CalibrationVerdict verdict, bool overdue, std::int64_t oldest_id, Status& event);

  StripCheck strip_check();
  StepResult check();

  Wiring wiring_;
  Cursor cursor_;  ///< first: the last keyframe examined; second: the last strip checked
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
