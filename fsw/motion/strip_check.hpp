// Whether the images of each strip fit the camera: its final poses and points in windows, and the record and event that
// say so.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/calibration/camera_check.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

inline constexpr std::size_t least_window_views = 3;

/// The strip after the last checked one.
struct StripCheckState {
  std::int64_t pose_id = 0;                                ///< newest one examined
  std::int64_t window_first_id = 0;                        ///< first keyframe of the next window; 0: that of the strip
  std::uint32_t posed = 0;                                 ///< posed keyframes from there up to pose_id
  CameraCheckVerdict reported = CameraCheckVerdict::fits;  ///< of the latest event
  CameraEvidence evidence;
};
struct StripCheckWork {
  bool window_loaded = false;
  StripRecord strip;
};
struct StripCheckWorkspace {
  FixedVector<std::int64_t, limits::max_calibration_views> ids;  ///< keyframes of the window
  BundleProblem window;
  MeasuredPlaces places;    ///< of the window's views
  MeasuredHeights heights;  ///< likewise
  WindowMotion motion;      ///< of the window's views
  IntrinsicsWorkspace equations;
  navigation::MeasuredKeyframes measured;  ///< of LensSearch: what the vehicle measured at posed keyframes
};

/// Windows overlap by one keyframe, and come once their points are final. A contradiction changes nothing. A window
/// that cannot be read adds nothing, and a strip whose records cannot be read is not checked.
class StripCheck {
 public:
  using Tables = StageStore<ComponentId::camera_calibrator>;
  struct Wiring {
    const Tables& store;
    const MissionParameters& mission;
    const CheckpointForm& checkpoint;
  };

  StripCheck(const Wiring& wiring, Cursor& cursor, StripCheckState& state, StripCheckWork& work, Patience& patience,
             StripCheckWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), state_(state), work_(work), patience_(patience), workspace_(workspace) {}

  /// The next pose, window or verdict; no: there is none yet. `event` is worth reporting.
  Result<bool> step(const CameraModel& camera, Status& event);
  /// Strips that were checked are not checked again: their points may have been released since.
  Status resume_after_records();

 private:
  Result<bool> follow_strip(const CameraModel& camera, Status& event);
  Status begin_window(const CameraModel& camera, Status& event);
  Status collect_keyframes();
  Status end_window(const CameraModel& camera, Status& event);
  Status commit(const Cursor& after, StripCheckState& after_state, const CalibrationCheckRecord* said);
  Status end_strip(std::int64_t strip_id);
  [[nodiscard]] std::int64_t input() const { return -(cursor_.second + 1); }  ///< for Patience

  const Wiring wiring_;
  Cursor& cursor_;  ///< second: the last strip checked
  StripCheckState& state_;
  StripCheckWork& work_;
  Patience& patience_;
  StripCheckWorkspace& workspace_;
};

}  // namespace ilp
