// Checks whether the images of each strip fit the camera, from final poses and points in windows, and writes a record
// and an event.
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

/// State of the check of the present strip.
struct StripCheckState {
  std::int64_t pose_id = 0;          ///< newest pose that was examined
  std::int64_t window_first_id = 0;  ///< first keyframe of the next window; 0: the first one of the strip
  std::uint32_t posed = 0;           ///< number of posed keyframes from window_first_id to pose_id
  CameraCheckVerdict reported = CameraCheckVerdict::fits;  ///< verdict of the latest event
  CameraEvidence evidence;
};
struct StripCheckWork {
  bool window_loaded = false;
  StripRecord strip;
};
struct StripCheckWorkspace {
  FixedVector<std::int64_t, limits::max_calibration_views> ids;  ///< keyframes of the window
  BundleProblem window;
  MeasuredPlaces places;    ///< positions of the window's views
  MeasuredHeights heights;  ///< heights of the window's views
  WindowMotion motion;      ///< motion of the window's views during the readout
  IntrinsicsWorkspace equations;
  navigation::MeasuredKeyframes measured;  ///< for LensSearch: the vehicle's measurements at posed keyframes
};

/// A strip is checked in windows that overlap by one keyframe, once their points are final. A contradiction is reported
/// and does not change the camera. A window that cannot be read is left out, and a strip whose records cannot be read
/// is not checked.
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

  /// Processes the next pose, window or verdict. Returns false if there is none yet. `event` is to be reported.
  Result<bool> step(const CameraModel& camera, Status& event);
  /// Continues after the strips that have a check on record, because their points may have been released.
  Status resume_after_records();

 private:
  Result<bool> follow_strip(const CameraModel& camera, Status& event);
  Status begin_window(const CameraModel& camera, Status& event);
  Status collect_keyframes();
  Status end_window(const CameraModel& camera, Status& event);
  Status commit(const Cursor& after, StripCheckState& after_state, const CalibrationCheckRecord* said);
  Status end_strip(std::int64_t strip_id);
  [[nodiscard]] std::int64_t input() const { return -(cursor_.second + 1); }  ///< identifies the strip for Patience

  const Wiring wiring_;
  Cursor& cursor_;  ///< Cursor::second is the last strip that was checked
  StripCheckState& state_;
  StripCheckWork& work_;
  Patience& patience_;
  StripCheckWorkspace& workspace_;
};

}  // namespace ilp
