// The camera of a flight in virtual time whose stages run in several processes.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/camera/camera.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Gives the next image when the stages that may still end the strip have finished with the images before it: then
/// every frame is compared with the same keyframe, however the stages are spread. These are the overlap checker and
/// structure and motion, and the camera calibrator while the camera is not known.
class HeldCamera final : public Camera {
 public:
  HeldCamera(Camera& camera, Store& store) : camera_(camera), store_(store) {}

  /// `not_ready` while it is held.
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool triggered() const override { return camera_.triggered(); }
  [[nodiscard]] bool restarts_counter() const override { return camera_.restarts_counter(); }
  Status trigger(TimeNs time) override { return camera_.trigger(time); }
  Status exposure_range(ExposureRange& range) override { return camera_.exposure_range(range); }
  Status set_exposure(ExposureSetting& setting) override { return camera_.set_exposure(setting); }
  [[nodiscard]] TimeNs granularity() const override { return camera_.granularity(); }
  [[nodiscard]] bool exposes_unasked() const override { return camera_.exposes_unasked(); }
  TimeNs next_due() const override { return camera_.next_due(); }

  /// The latest call of capture() was held: mission time must not pass.
  [[nodiscard]] bool held() const { return held_; }

 private:
  Result<bool> caught_up();

  Camera& camera_;
  Store& store_;
  bool held_ = false;
};

}  // namespace ilp
