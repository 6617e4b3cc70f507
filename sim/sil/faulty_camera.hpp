// Wraps a camera and injects the faults of a plan.
#pragma once

#include <deque>
#include <vector>

#include "hal/camera/camera.hpp"
#include "sim/sil/fault_plan.hpp"

namespace ilp::sil {

/// Number of frames with each fault.
struct CameraFaultCounts {
  std::int64_t lost = 0;
  std::int64_t dead = 0;  ///< dropped because the camera was dead
  std::int64_t duplicated = 0;
  std::int64_t late = 0;
  std::int64_t misstamped = 0;
  std::int64_t black = 0;
  std::int64_t saturated = 0;
  std::int64_t blurred = 0;
};

/// A frame has at most one fault of delivery: the first that applies of dead, lost, late, misstamped and duplicated.
/// Its image has at most one fault: the first of black, saturated and blurred. The choice depends on the seed and the
/// sequence number only, for `dead` on the frame's time. Errors of the wrapped camera are returned unchanged.
class FaultyCamera final : public Camera {
 public:
  FaultyCamera(Camera& camera, const FaultPlan& plan, std::uint64_t seed);

  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  TimeNs next_due() const override;
  [[nodiscard]] bool triggered() const override { return camera_.triggered(); }
  [[nodiscard]] bool restarts_counter() const override { return camera_.restarts_counter(); }
  [[nodiscard]] TimeNs granularity() const override { return camera_.granularity(); }
  [[nodiscard]] bool exposes_unasked() const override { return camera_.exposes_unasked(); }
  Status trigger(TimeNs time) override { return camera_.trigger(time); }
  Status exposure_range(ExposureRange& range) override { return camera_.exposure_range(range); }
  Status set_exposure(ExposureSetting& setting) override { return camera_.set_exposure(setting); }

  [[nodiscard]] const CameraFaultCounts& counts() const { return counts_; }
  /// The wrapped camera has given its last frame.
  [[nodiscard]] bool source_ended() const { return source_ended_; }
  /// The highest sequence number that the wrapped camera has given.
  [[nodiscard]] std::int64_t newest_sequence() const { return newest_sequence_; }

 private:
  struct Held {
    TimeNs due = 0;
    CameraFrame frame;
    std::int32_t width = 0, height = 0;
    std::vector<std::uint8_t> pixels;
  };
  enum class Fate { passed, swallowed };

  [[nodiscard]] bool strikes_frame(const char* kind, double share, const CameraFrame& frame) const;
  void hold(TimeNs due, const FrameImage& image, const CameraFrame& frame);
  bool release(TimeNs now, FrameImage& image, CameraFrame& frame);
  void spoil_image(FrameImage& image, const CameraFrame& frame);
  Fate spoil_way(const FrameImage& image, CameraFrame& frame);

  Camera& camera_;
  FaultPlan plan_;
  std::uint64_t seed_;
  CameraFaultCounts counts_;
  std::deque<Held> held_;  ///< in the order of their release
  bool source_ended_ = false;
  std::int64_t newest_sequence_ = 0;
};

/// Box filter of 2 `radius_px` + 1 pixels a side, applied twice. Edge pixels are repeated beyond the edges.
void blur(ImageView<std::uint8_t> image, int radius_px);

}  // namespace ilp::sil
