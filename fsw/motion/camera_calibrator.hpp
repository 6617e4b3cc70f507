// Self-calibration: estimates an unknown camera from the images of keyframes and freezes it, then checks every strip
// against the frozen camera (paper 3.2.1; decisions.md, 6).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/motion/lens_search.hpp"
#include "fsw/motion/strip_check.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// Runs LensSearch until the camera is frozen, then StripCheck.
class CameraCalibrator final : public StageComponent<ComponentId::camera_calibrator> {
 public:
  static const CheckpointForm checkpoint;

  CameraCalibrator(Tables store, const MissionParameters& mission);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override;

 private:
  struct Wiring {
    Tables store;
    const MissionParameters& mission;
  };
  using State = StripCheckState;
  struct Work {
    CameraRecord camera;
    Patience patience;
    StripCheckWork check;
    LensSearchWork search;
  };
  using Workspace = StripCheckWorkspace;

  StripCheck strip_check();
  LensSearch lens_search();

  Wiring wiring_;
  Cursor cursor_;  ///< Cursor::second is the last strip that was checked
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
