// A camera that fails as planned, in front of any other camera.
#pragma once

#include <deque>
#include <vector>

#include "hal/camera/camera.hpp"
#include "sim/sil/fault_plan.hpp"

namespace ilp::sil {

/// How many frames met which fault.
struct CameraFaultCounts {
  std::int64_t lost = 0;
  std::int64_t dead = 0;  ///< frames that were not taken while the camera was dead
  std::int64_t duplicated = 0;
  std::int64_t late = 0;
  std::int64_t misstamped = 0;
  std::int64_t black = 0;
  std::int64_t saturated = 0;
  std::int64_t blurred = 0;
};

/// A frame gets at most one fault (dead, lost, late, misstamped, duplicated, in this order), and its image at
/// most one (black, saturated, blurred). The choice of frames depends only on the seed and the sequence number. Frames
/// that the wrapped camera itself has lost pass through.
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

/// Mean over a square of 2 radius + 1 pixels, beyond the edges the nearest pixel; applied twice.
void blur(ImageView<std::uint8_t> image, int radius_px);

}  // namespace ilp::sil
