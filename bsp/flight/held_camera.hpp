// Delays the images of a flight in virtual time whose stages run in several processes, until all of them are ready.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/camera/camera.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Delivers the next image when the stages that may still end the strip have finished with all earlier images. These
/// are the overlap checker, structure and motion, and the camera calibrator while the camera is not known. Every frame
/// is then compared with the same keyframe, however the stages are distributed.
class HeldCamera final : public Camera {
 public:
  HeldCamera(Camera& camera, Store& store) : camera_(camera), store_(store) {}

  /// Returns `not_ready` also while the next image is held back.
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool triggered() const override { return camera_.triggered(); }
  [[nodiscard]] bool restarts_counter() const override { return camera_.restarts_counter(); }
  Status trigger(TimeNs time) override { return camera_.trigger(time); }
  Status exposure_range(ExposureRange& range) override { return camera_.exposure_range(range); }
  Status set_exposure(ExposureSetting& setting) override { return camera_.set_exposure(setting); }
  [[nodiscard]] TimeNs granularity() const override { return camera_.granularity(); }
  [[nodiscard]] bool exposes_unasked() const override { return camera_.exposes_unasked(); }
  TimeNs next_due() const override { return camera_.next_due(); }

  /// Whether the latest call of capture() held an image back. Mission time must not advance then.
  [[nodiscard]] bool held() const { return held_; }

 private:
  /// Whether the stages have finished with all earlier images.
  Result<bool> caught_up();

  Camera& camera_;
  Store& store_;
  bool held_ = false;
};

}  // namespace ilp
