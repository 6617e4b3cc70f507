// Takes images from the camera into the store: Camera -> Frame.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/components/checkpoint.hpp"
#include "fsw/executive/component.hpp"
#include "hal/camera/camera.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// Regular-interval mode: takes the camera's frames, at most one per capture interval. Lost, mis-stamped and wrongly
/// sized frames are reported and the flight goes on. When the source ends, the open strip is commanded to end.
class Acquisition final : public Component {
 public:
  Acquisition(Store& store, Camera& camera, Clock& clock, const MissionParameters& mission);

  [[nodiscard]] const char* name() const override { return "acquisition"; }
  Status restore() override;
  StepResult step(TimeNs deadline) override;

  [[nodiscard]] bool ended() const { return state_.ended; }

 private:
  struct State {
    std::int64_t last_sequence = 0;
    TimeNs last_time_ns = 0;
    bool any = false;
    bool ended = false;
    std::uint8_t padding[6] = {};
  };

  Status keep(const CameraFrame& taken);
  Status end_of_stream();

  Store& store_;
  Camera& camera_;
  Clock& clock_;
  const MissionParameters& mission_;
  Cursor cursor_;
  State state_;
  FrameImage image_;
};

}  // namespace ilp
