// The pose of each keyframe: Keyframe -> Pose, provisional and then final (paper 3.2; decisions.md, 4 to 7).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/motion/keyframe_features.hpp"
#include "fsw/motion/shutter_errors.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// Processes one keyframe at a time, in slices: corners, matches to the newest posed keyframe, the steps of Sequence,
/// records. The first keyframes of a strip may wait, related but without a pose, until a pair of them can begin the
/// structure, at the latest until the strip ends. A keyframe that cannot be related gets a failed pose with its
/// verdict, and the next one is related to the last keyframe before it; after two failures in a row the strip is
/// abandoned. Before a keyframe fails, it is tried against the two posed keyframes before the newest one, whose points
/// it may see though the newest one is a bad image; where the newest one holds few points, these two come first. When a
/// strip has ended, its last poses become final. While the camera is not frozen, poses are trials, for the search for
/// the camera, and every change of the camera starts them over. A keyframe whose image cannot be read
/// counts as one that cannot be related. If the checkpoint is lost, the poses that were not final fail, and so does the
/// rest of the strip, whose end is commanded. A final pose never changes.
class StructureAndMotion final : public StageComponent<ComponentId::structure_and_motion> {
 public:
  static const CheckpointForm checkpoint;

  /// The points of a batch beside what their sequence needs.
  struct FinalsWorkspace {
    SequenceWorkspace sequence;
    std::uint32_t point_count;
    FixedVector<std::uint8_t, limits::max_structure_bytes> points;
  };
  using Scratch = StepScratch<FeatureScratch, SequenceWorkspace, FinalsWorkspace>;

  StructureAndMotion(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override;

 private:
  enum class Phase : std::uint8_t { idle, load, detect, begin_match, match, relate, sequence, record, finish };

  struct Wiring {
    Tables store;
    const MissionParameters& mission;
    Scratch scratch;
  };
  struct State {
    SequenceState sequence;
    std::int32_t camera_revision = 0;    ///< by which all poses so far were made
    std::int64_t examined_id = 0;        ///< newest keyframe examined with it; the cursor is the newest of all
    std::int64_t strip_id = 0;           ///< 0: no strip is open
    std::int64_t posed_keyframe_id = 0;  ///< newest keyframe of the strip that has a pose or waits for it
    std::uint32_t failures = 0;          ///< failures in a row
    bool lost = false;                   ///< the strip was abandoned: its later keyframes have no pose
    bool end_commanded = false;          ///< the end of the lost strip was commanded
    ScaleSource scale_source = ScaleSource::first_baseline;
    BaselineErrors baseline_errors;  ///< of a rolling shutter
    double last_from_posed[9] = {1, 0, 0, 0, 1,
                                 0, 0, 0, 1};  ///< predicts pixels of the posed keyframe in the last keyframe examined
  };
  struct Work {
    CameraRecord camera;
    // The keyframe at work; a restart drops it.
    Phase phase = Phase::idle;
    KeyframeRecord keyframe;
    ShutterRecord shutter;        ///< its motion, where the camera has a rolling shutter
    bool on_record = false;       ///< it has a pose, made before the checkpoint was damaged
    bool newest_is_poor = false;  ///< it is tried against the newest posed keyframe last
    std::uint32_t attempt = 0;
    std::size_t detected = 0;      ///< its corners without those of tracking
    SequenceReport newest_report;  ///< on its relation to the newest posed keyframe
    std::int64_t subject = 0;      ///< subject of the step for Patience: the keyframe, or the end of a strip
    Patience patience;
    bool keeps = false;  ///< the search for corners or matches goes on in the step's memory
  };
  struct Workspace {
    double predicted[9]{};  ///< pixels of the keyframe that it is matched with in this one
    KeyframeImages images;  ///< previous: image of a posed keyframe
    Corners corners;
    Corners older_corners;
    Matches matches;
    FixedVector<float, limits::max_tracks> depths;
  };

  Status advance();
  Status start_over();
  Status begin_keyframe(bool no_use, const NavigationRecord& measured);
  Result<bool> pick();
  Status load();
  Status detect();
  Status begin_match();
  Status begin_match_to_older();
  Status match();
  /// The keyframe at work is tried against the posed keyframe so many before the newest one.
  [[nodiscard]] std::uint32_t back() const;
  /// Whether there is another keyframe to be tried against.
  bool try_next();
  Status extend_sequence();
  Status record();
  Status record_success();
  Status record_failure();
  Status finish_strip();
  Status end_strip();
  Status begin_strip();
  Status abandon_strip();
  Status write_camera(const SequenceCamera& camera, bool final_pose);
  Status write_finals();

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
