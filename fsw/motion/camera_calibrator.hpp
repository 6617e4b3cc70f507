// Finds an unknown camera by the poses of its keyframes and freezes it, then checks strips against the frozen one
// (paper 3.2.1; decisions.md, 6).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/motion/lens_search.hpp"
#include "fsw/motion/strip_check.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// LensSearch until the camera is frozen, then StripCheck.
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
  Cursor cursor_;  ///< second: the last strip checked
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
