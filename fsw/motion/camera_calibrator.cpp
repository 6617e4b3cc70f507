#include "fsw/motion/camera_calibrator.hpp"

#include "fsw/shared/camera_on_record.hpp"

namespace ilp {

constexpr CheckpointForm CameraCalibrator::checkpoint = checkpoint_form<State>(component_id);

CameraCalibrator::CameraCalibrator(Tables store, const MissionParameters& mission) : wiring_{store, mission} {}

LastingMemory CameraCalibrator::lasting() const {
  return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
}

Status CameraCalibrator::restore() {
  state_ = {};
  work_.check.window_loaded = false;
  work_.search = {};
  ILP_TRY(get_camera(wiring_.store, camera_id, work_.camera));
  const Status loaded = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (loaded.is(StatusCode::checkpoint_lost)) ILP_TRY(strip_check().resume_after_records());
  return loaded;
}

StripCheck CameraCalibrator::strip_check() {
  return {{wiring_.store, wiring_.mission, checkpoint}, cursor_, state_, work_.check, work_.patience, workspace_};
}

LensSearch CameraCalibrator::lens_search() {
  return {{wiring_.store, wiring_.mission, checkpoint}, cursor_, state_, work_.search, work_.patience, workspace_};
}

StepResult CameraCalibrator::step() {
  Status event;
  const bool frozen = work_.camera.frozen != Flag{};
  const Result<bool> pending =
      frozen ? strip_check().step(camera_model(work_.camera), event) : lens_search().step(work_.camera, event);
  if (pending.ok()) return {event, pending.value()};
  // A strip counts as an input of its own that may be abandoned.
  return work_.patience.failed(frozen ? -(cursor_.second + 1) : lens_search().input(), pending.status());
}

}  // namespace ilp
