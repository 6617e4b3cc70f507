// Self-calibration of an unknown camera: estimates its intrinsics and readout time (paper 3.2.1; decisions.md, 6).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/motion/strip_check.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/calibration/lens_solution.hpp"

namespace ilp {

/// One pass over the keyframes. A restart begins the pass again: lasting results are in the camera's record.
struct LensSearchWork {
  bool solving = false;             ///< the pass has enough poses, and rounds are computed
  bool last = false;                ///< no further keyframe will come, so that there is no next pass
  std::int64_t looked_id = 0;       ///< newest keyframe whose pose was counted; while solving, the last one of the pass
  std::int64_t first_frame_id = 0;  ///< frame of the oldest keyframe
  std::int64_t first_id = 0;        ///< the oldest keyframe
  std::uint32_t posed = 0;          ///< number of posed keyframes
  std::uint32_t least_posed = 0;  ///< least value of `posed` for a new attempt, after one in which no window had points
  bool placed = false;            ///< `origin` is known
  BodyPlace origin;               ///< origin of the keyframes' positions
  std::int64_t window_id = 0;     ///< first keyframe of the next window
  std::uint32_t round = 0;
  CameraModel camera;  ///< camera of the round
  CameraEvidence evidence;
  /// Result of the round before.
  struct Solution {
    LensStep step;
    CameraCheck check;
    std::uint32_t windows = 0, points = 0;
  } before;
  CameraModel stepped_from;  ///< the camera of the round before
};

/// Structure and motion computes trial poses with the present camera. Once a pass has enough poses, the camera is
/// estimated in rounds: each window of six keyframes (windows overlap by one) adds its equations, and the camera takes
/// a step, until the step is small. The result is the next revision of the camera, with which all poses are computed
/// again, because a better camera gives longer tracks. Revision 1 is computed from 6 poses, 2 from 16, 3 from 36, and 4
/// when the mission's time limit ends; at the end of the flight the poses that exist are used. From the second pass on
/// the camera is frozen if the images determine the lens, or if no further keyframes will come. Intrinsics that the
/// images leave undetermined keep their given values and errors. Attitudes and positions that the vehicle measured are
/// used.
class LensSearch {
 public:
  using Tables = StageStore<ComponentId::camera_calibrator>;
  using Wiring = StripCheck::Wiring;

  LensSearch(const Wiring& wiring, Cursor& cursor, StripCheckState& state, LensSearchWork& work, Patience& patience,
             StripCheckWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), state_(state), work_(work), patience_(patience), workspace_(workspace) {}

  /// Processes the next pose, window or round. Returns false if there is none yet. `event` is to be reported. `camera`
  /// becomes the new revision at the end of a pass.
  Result<bool> step(CameraRecord& camera, Status& event);
  /// Identifies the present input for Patience.
  [[nodiscard]] std::int64_t input() const { return -(work_.looked_id + 1); }

 private:
  Result<bool> follow_poses(const CameraRecord& camera);
  [[nodiscard]] bool has_enough(const CameraRecord& camera) const;
  Status collect_window(const CameraRecord& camera);
  Status load_window(const CameraRecord& camera);
  Result<bool> follow_vehicle(const PoseRecord& pose);
  Status add_window_to_round(const CameraRecord& camera, Status& event);
  Status end_round(CameraRecord& camera, Status& event);
  [[nodiscard]] LensPrior prior(const CameraModel& nominal) const;
  Status conclude(const LensPrior& prior, const LensSearchWork::Solution& found, CameraRecord& camera, Status& event);
  void begin_round(const CameraModel& camera);

  const Wiring wiring_;
  Cursor& cursor_;
  StripCheckState& state_;
  LensSearchWork& work_;
  Patience& patience_;
  StripCheckWorkspace& workspace_;
};

}  // namespace ilp
