// The search for the intrinsics and the readout time of a camera that is not known (paper 3.2.1; decisions.md, 6).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/motion/strip_check.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/calibration/lens_solution.hpp"

namespace ilp {

/// One pass over the keyframes. A restart starts it over: everything that lasts is in the camera's record.
struct LensSearchWork {
  bool solving = false;
  bool last = false;                ///< no keyframe will come that the next pass could wait for
  std::int64_t looked_id = 0;       ///< newest keyframe whose pose was counted; while solving, the last one of the pass
  std::int64_t first_frame_id = 0;  ///< of the oldest keyframe
  std::int64_t first_id = 0;
  std::uint32_t posed = 0;
  std::uint32_t least_posed = 0;  ///< fewer have no window: the points that they see have not ended yet
  bool placed = false;
  BodyPlace origin;            ///< from where places count
  std::int64_t window_id = 0;  ///< where the next window begins
  std::uint32_t round = 0;
  CameraModel camera;  ///< of the round
  CameraEvidence evidence;
  /// What the round before has said of its camera.
  struct Solution {
    LensStep step;
    CameraCheck check;
    std::uint32_t windows = 0, points = 0;
  } before;
  CameraModel stepped_from;  ///< the camera of the round before
};

/// Structure and motion poses the keyframes by the camera as it is; each pose is a trial. Once a pass has enough of
/// them, the camera is moved by rounds: every window of six keyframes, which overlap by one, adds its equations, and a
/// step is taken, until it is short. The camera's next revision makes all poses again, because its tracks are longer.
/// Revision 1 comes with 6 poses, 2 with 16, 3 with 36, 4 when the mission's patience ends; the flight's end brings
/// what it finds. From the second pass on the camera is frozen where the images determine the lens, or where nothing
/// else will come. What the images leave open stays as it was given, with its error. Attitudes and
/// places that the vehicle measured are used.
class LensSearch {
 public:
  using Tables = StageStore<ComponentId::camera_calibrator>;
  using Wiring = StripCheck::Wiring;

  LensSearch(const Wiring& wiring, Cursor& cursor, StripCheckState& state, LensSearchWork& work, Patience& patience,
             StripCheckWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), state_(state), work_(work), patience_(patience), workspace_(workspace) {}

  /// The next pose, window or round; no: there is none yet. `event` is worth reporting; `camera` becomes what was
  /// found.
  Result<bool> step(CameraRecord& camera, Status& event);
  /// For Patience.
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
