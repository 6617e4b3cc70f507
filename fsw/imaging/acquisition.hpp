// Takes images from the camera into the store: Capture -> Frame.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/lock_times.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/imaging/exposure_control.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/camera/camera.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// Assigns to every capture exactly one frame, the camera's nearest to the requested time, or the state `no_frame` with
/// an event. Without captures (regular mode with interval 0) every frame is taken. Frames that are lost, repeated, out
/// of order, late, mis-stamped or wrongly sized are detected from the camera's counter and period, the clock and the
/// image; they are reported, and the flight goes on. When the source ends, the component commands the end of the open
/// strip. If a frame cannot be stored because of a transient fault, it is held until it is stored, and no other frame
/// is taken meanwhile. No frame gets the number of a stored frame. With `exposure_control` the component sets the
/// camera's exposure after each image (docs/exposure.md).
class Acquisition final : public StageComponent<ComponentId::acquisition> {
 public:
  static const CheckpointForm checkpoint;

  Acquisition(Tables store, Camera& camera, Clock& clock, const MissionParameters& mission);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  }

  [[nodiscard]] bool ended() const { return state_.ended; }

  static constexpr std::size_t max_pending = 40;  ///< pending captures: all telecommanded ones and some of the mode

 private:
  struct Pending {
    std::int64_t id = 0;
    TimeNs time_ns = 0;
  };
  struct Wiring {
    Tables store;
    Camera& camera;
    Clock& clock;
    const MissionParameters& mission;
  };
  struct State {
    std::int64_t last_sequence = 0;
    TimeNs last_time_ns = 0;      ///< time of the latest frame seen, taken or not
    TimeNs period_ns = 0;         ///< period of a camera that runs freely
    std::int32_t steadiness = 0;  ///< how well the period has held; from `steady` on it is used to judge frames
    std::uint32_t last_crc32 = 0;
    FixedVector<Pending, max_pending> pending;  ///< in order of time
    bool any = false;
    bool any_kept = false;
    bool ended = false;
  };
  /// The frame that is processed; its pixels are in the workspace.
  struct FrameAtWork {
    CameraFrame taken;
    TimeNs taken_ns = 0;
    bool held = false;     ///< it could not be stored yet and is tried again
    bool unasked = false;  ///< the camera's present mode: it runs freely and exposes at times of its own
  };
  struct Work {
    /// The camera's counter at the restart. Earlier frames that the source gives again are not reported.
    std::int64_t restored_sequence = 0;
    FrameAtWork frame;       ///< restore() keeps it
    TimeNs received_ns = 0;  ///< when the camera last gave a frame, or was first asked
    ExposureControl exposure = {};
    double speed_px_s = 0;           ///< speed of the ground in the image, the largest of the latest images
    Status next_event = {};          ///< the event that the next step reports
    LockTimes lock = {};             ///< the store's lock, as this component's attempts to write found it
    std::int64_t seen_sequence = 0;  ///< counter of a frame that was not wanted and not noted, because of the lock
    bool asked = false;              ///< the camera has been asked for a frame
    bool held_by_lock = false;
    bool silent = false;
  };
  struct Workspace {
    FrameImage image;
  };
  struct Outcome {
    State after = {};
    Cursor cursor = {};
    FrameRecord frame = {};
    CaptureRecord capture = {};
    bool has_frame = false;
    bool has_capture = false;
    Status event = {};
  };

  Result<bool> learn_captures(Outcome& outcome) const;
  Result<bool> abandon_captures(Outcome& outcome) const;
  [[nodiscard]] bool every_frame() const;
  /// The largest distance of a commanded image from its time. A farther one is a failure.
  [[nodiscard]] TimeNs grain() const;
  Status trigger(TimeNs now);
  bool repeats(const CameraFrame& taken, Outcome& outcome) const;
  /// Corrects the frame's time if it is suspect. A fault is the event to report: the time is impossible, and the frame
  /// is not used.
  Result<TimeDoubt> judge_time(CameraFrame& taken, TimeNs now, Outcome& outcome) const;
  void learn_period(TimeNs since_last, std::int64_t exposures, State& after) const;
  Status choose_capture(const CameraFrame& taken, TimeDoubt suspicion, Outcome& outcome);
  Status take(CameraFrame& taken, TimeNs now, Outcome& outcome);
  void keep(const CameraFrame& taken, TimeDoubt suspicion, std::int64_t capture_id, Outcome& outcome) const;
  Status listen(TimeNs now);
  Status end_of_stream();
  Status write(Outcome& outcome);
  Status write_all(Outcome& outcome);
  /// Reports the images that were lost while another process held the store's lock, once the lock is free.
  void count_lost(Outcome& outcome);
  Status resume_after_records();
  StepResult store_taken();
  void control_exposure();
  bool begin_exposure_control();

  Wiring wiring_;
  Cursor cursor_;  // frames kept; captures seen
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
