// Chooses which frames are worth processing: Frame -> Keyframe (paper 3.1; decisions.md, 1).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// The first frame at or below the target overlap with the latest keyframe is the next keyframe. When a frame has moved
/// too far already, the frame before it is taken instead, if it can be bridged; otherwise the strip ends and a new one
/// begins. A frame that cannot be compared (dark, blurred, without texture) is left out; two in a row that have texture
/// but match nothing end the strip, and the first of them begins the next one. No strip begins with a frame that cannot
/// be compared. A frame that cannot be read is left out; where the keyframe cannot, the strip ends and the next frame
/// begins another one. Where the checkpoint is behind what is on record, the open strip ends too.
class OverlapChecker final : public StageComponent<ComponentId::overlap_checker> {
 public:
  static const CheckpointForm checkpoint;

  OverlapChecker(Tables store, const MissionParameters& mission);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory(cursor_, state_).of(*this).at_work(patience_, loaded_frame_id_).changed_by_commits();
  }

 private:
  /// Candidate: the latest frame that was seen, measured and not yet needed.
  struct Candidate {
    std::int64_t frame_id = 0;
    double overlap = 0;
    double plane_from_keyframe[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  };
  struct State {
    std::int64_t strip_id = 0;  ///< 0: none open
    std::int64_t last_strip_id = 0;
    std::int64_t last_keyframe_id = 0;
    std::int64_t keyframe_id = 0;  ///< the open strip's latest, 0: none
    std::int64_t keyframe_frame_id = 0;
    std::int64_t index = 0;             ///< of the next keyframe in its strip
    std::int64_t unknown_frame_id = 0;  ///< a frame that matched nothing, waiting for a second opinion; 0: none
    double last_rotation_rad = 0;       ///< of the last frame against the keyframe
    double last_scale = 1;
    Candidate candidate;
    bool motion_known = false;  ///< some frame of this strip was measured
    std::uint8_t padding[7] = {};
  };
  /// What one step decided; written in one transaction.
  struct Outcome {
    State after;
    Cursor cursor;
    OverlapRecord overlap;
    KeyframeRecord keyframe;
    StripRecord ended;
    StripRecord strip;
    bool has_overlap = false;
    bool has_keyframe = false;
    bool has_ended = false;
    Status event;
  };

  /// Nothing of what was chosen since the checkpoint is chosen again.
  Status go_on_behind_records();
  Status load_keyframe(std::int64_t frame_id);
  Status correlate(OverlapResult& measured);
  Status handle_command(Outcome& outcome, bool& handled);
  Status measure(const FrameRecord& frame, OverlapResult& measured);
  /// Is the frame good enough for others to be compared with it?
  Status judge_alone(const FrameRecord& frame, OverlapVerdict& verdict);
  Status look_at(const FrameRecord& frame, Outcome& outcome);
  void select(const FrameRecord& frame, const OverlapResult& measured, Outcome& outcome) const;
  void begin_strip(const FrameRecord& frame, Outcome& outcome) const;
  void end_strip(StripEnd reason, Outcome& outcome) const;
  Status select_candidate(Outcome& outcome) const;
  Status load_strip(const Outcome& outcome, std::int64_t id, StripRecord& strip);
  Status write(const Outcome& outcome);
  StepResult choose(const Status& found, const FrameRecord& frame, Outcome& outcome);

  Tables store_;
  const MissionParameters& mission_;
  Cursor cursor_;
  State state_;
  Patience patience_;
  bool keyframe_unreadable_ = false;  ///< found so by the step
  std::int64_t loaded_frame_id_ = 0;
  FrameImage keyframe_image_;
  OverlapTemplate keyframe_;  // of that image
  FrameImage image_;
  OverlapWorkspace workspace_;
  FeatureOverlapWorkspace features_;
};

}  // namespace ilp
