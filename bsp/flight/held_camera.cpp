#include "bsp/flight/held_camera.hpp"

#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {

Status HeldCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  const Result<bool> ready = caught_up();
  held_ = !ready.value();
  if (!ready.ok() && !is_transient(ready.status())) return ready.status();
  return held_ ? Status{StatusCode::not_ready} : camera_.capture(now, image, frame);
}

Result<bool> HeldCamera::caught_up() {
  std::int64_t frame = 0, overlap = 0, keyframe = 0, said = 0;
  ILP_TRY(newest_id<OverlapRecord>(store_, overlap));
  ILP_TRY(newest_id<FrameRecord>(store_, frame));
  if (overlap < frame) return false;
  ILP_TRY(newest_id<KeyframeRecord>(store_, keyframe));
  CameraRecord camera;
  ILP_TRY(get_camera(store_, camera_id, camera));
  ILP_TRY(newest_id<PoseRecord>(store_, said));
  PoseRecord pose;
  ILP_TAKE(const bool known, find(store_, keyframe, pose));
  // A camera that was changed makes all poses again.
  return said >= keyframe && (!known || pose.camera_revision == camera.revision);
}

}  // namespace ilp
