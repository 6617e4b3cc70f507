// Takes images from the camera into the store: Camera -> Frame.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/components/checkpoint.hpp"
#include "fsw/executive/component.hpp"
#include "hal/camera/camera.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// Regular-interval mode: takes the camera's frames, at most one per capture interval. Frames that are lost, wrongly
/// sized, stamped before their predecessor or ahead of the clock, repeated or out of order are reported and left out;
/// the flight goes on. When the source ends, the open strip is commanded to end.
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

  Status refuse(const CameraFrame& taken, const Status& why);
  Status check_stamp(const CameraFrame& taken, TimeNs now) const;
  Status listen(TimeNs now);
  Status keep(const CameraFrame& taken);
  Status end_of_stream();

  Store& store_;
  Camera& camera_;
  Clock& clock_;
  const MissionParameters& mission_;
  Cursor cursor_;
  State state_;
  // Of this life only: what the source repeats after a restart is no news.
  std::int64_t restored_sequence_ = 0;  ///< frames up to it were dealt with before the restart
  std::int64_t newest_sequence_ = 0;    ///< that the camera has handed over
  std::int64_t left_out_ = 0;           ///< frames since the last stored one that arrived and were not stored
  TimeNs heard_ns_ = -1;                ///< when the camera last handed over a frame, or was first asked; -1: not yet
  TimeNs interval_ns_ = 0;              ///< between frames, 0: unknown
  bool silent_ = false;
  FrameImage image_;
};

}  // namespace ilp
