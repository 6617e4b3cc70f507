// Decides when the next image is wanted: Overlap, Pose, Fix, Command -> Capture (paper 3.1; decisions.md, 3).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/lock_times.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/imaging/place_captures.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/shared/valid_store.hpp"
#include "fsw/vision/forecast/capture_forecast.hpp"
#include "hal/camera/camera.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// There are three modes:
/// - regular: a constant interval;
/// - forecast: the time at which the overlap with the latest keyframe will have fallen to its target, extrapolated from
///   the overlaps so far. If the forecast's error is large, a frame is taken earlier; if the motion is unknown, a safe
///   interval after the last frame. A new pose shows how the gondola swings, so that an earlier forecast is replaced;
/// - telecommanded times only.
/// Telecommanded times are used in every mode and have precedence. Captures are never closer together than the camera's
/// least interval. A telecommanded time that has passed, or that is too near to another one, is rejected with an event.
/// A telecommand may also name a place: the image is taken when the vehicle is nearest to it, as forecast from its
/// latest positions (place_captures.hpp). For a rolling shutter, a capture that is soon due gets a burst: two captures
/// before and two after it, as near as the camera allows. All other captures have precedence over those of a burst.
class CaptureClock final : public StageComponent<ComponentId::capture_clock> {
 public:
  static const CheckpointForm checkpoint;

  CaptureClock(Tables store, const Camera& camera, Clock& clock, const MissionParameters& mission);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  }

  static constexpr std::size_t max_telecommanded = 32;  ///< pending telecommanded captures
  static constexpr std::size_t burst_frames = 4;        ///< captures of a burst, half of them before its capture

 private:
  struct Wanted {
    std::int64_t id = 0;
    TimeNs time_ns = 0;
  };
  struct Wiring {
    Tables whole;  ///< the store with damaged records, for the checkpoint
    ValidView<Tables::tables> store;
    const Camera& camera;
    Clock& clock;
    const MissionParameters& mission;
  };
  struct State {
    ApparentPath path;
    std::int64_t first_keyframe_id = 0;  ///< keyframe that began the path
    std::int64_t keyframe_id = 0;        ///< latest keyframe of the path; 0: none
    std::int64_t last_pose_id = 0;
    double q_first_from_world[4] = {0, 0, 0, 0};  ///< attitude of the image that began the path; 0: not known yet
    std::int64_t last_capture_id = 0;
    Wanted own;  ///< pending capture of the mode; id 0: none
    TimeNs last_regular_ns = 0;
    FixedVector<Wanted, max_telecommanded> telecommanded;  ///< pending
    FixedVector<Wanted, burst_frames> burst;               ///< captures of the newest burst
    TimeNs burst_of_ns = -1;                               ///< time of the capture of that burst; -1: none
    PlaceCaptures at_places;
    std::int32_t width = 0, height = 0;
    bool any_regular = false;
    bool ended = false;
    bool tilt_has_changed = false;  ///< the pending forecast was made before the latest attitude was known
  };
  struct Work {
    LockTimes lock;  ///< the store's lock; while it is taken nothing can be planned
  };
  struct Workspace {
    MotionForecast motion;
  };
  /// The decisions of one step, written in one transaction.
  struct Outcome {
    State after = {};
    Cursor cursor = {};
    CaptureRecord capture = {};
    CaptureRecord superseded = {};
    FixedVector<CaptureRecord, 2 * burst_frames> burst = {};  ///< new captures of a burst, and superseded ones
    bool has_capture = false;
    bool has_superseded = false;
    Status event = {};
  };

  Result<bool> handle_command(Outcome& outcome);
  Status accept_telecommand(const CommandRecord& command, Outcome& outcome);
  Result<bool> follow_overlap(Outcome& outcome);
  Result<bool> follow_pose(Outcome& outcome);
  Status take_attitude(const PoseRecord& pose, double focal_px, State& after);
  Status reconsider(const FrameRecord* latest, TimeNs now, Outcome& outcome);
  Status follow_keyframe(const OverlapRecord& overlap, const FrameRecord& frame, State& after);
  Result<bool> forget_past_captures(State& after);
  /// Plans the image of a place that will soon be passed, or abandons a place that was not passed in its time.
  Status plan_place(Outcome& outcome);
  Status plan(Outcome& outcome);
  void plan_regular(double interval_s, const FrameRecord* latest, TimeNs now, Outcome& outcome) const;
  void plan_forecast(const FrameRecord* latest, TimeNs now, Outcome& outcome);
  struct ForecastTime {
    TimeNs time_ns = 0;
    CaptureSource source = CaptureSource::safe;
    MotionForecast::Overlap expected;
  };
  [[nodiscard]] ForecastTime forecast_time(const FrameRecord& latest, TimeNs now, const State& state);
  void want_forecast(const ForecastTime& forecast, Outcome& outcome);
  void want(TimeNs time_ns, CaptureSource source, Outcome& outcome) const;
  Status plan_burst(Outcome& outcome) const;
  /// Supersedes captures of the burst that are too near to the new capture.
  Status clear_burst(Outcome& outcome) const;
  [[nodiscard]] bool too_near(TimeNs time_ns, const State& state, TimeNs latest_exposure_ns) const;
  /// Brings the state up to the records that are newer than the checkpoint.
  Status resume_after_records(bool lost);
  Status write(Outcome& outcome);
  /// Notes that nothing can be planned, because another process holds the store's lock.
  void note_lock();

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
