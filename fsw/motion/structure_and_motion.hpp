// Computes the pose of each keyframe, provisional and then final: Keyframe -> Pose (paper 3.2; decisions.md, 4 to 7).
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
/// records. The first keyframes of a strip may be related to each other but wait for their poses until a pair of them
/// can begin the structure, at the latest until the strip ends. When a strip has ended, its last poses become final. A
/// final pose never changes.
///
/// If a keyframe cannot be related to the newest posed keyframe, which may be a bad image, it is tried against the two
/// posed keyframes before that one. If the newest one has few points, these two are tried first. A keyframe that cannot
/// be related, or whose image cannot be read, gets a failed pose with a verdict, and the next keyframe is related to
/// the last posed one. After two failures in a row the strip is abandoned.
///
/// While the camera is not frozen, poses are trials for the self-calibration, and every change of the camera starts
/// them again. If the checkpoint is lost, poses that were not final fail; the rest of the strip fails too, and its end
/// is commanded.
class StructureAndMotion final : public StageComponent<ComponentId::structure_and_motion> {
 public:
  static const CheckpointForm checkpoint;

  /// Scratch for the final points of a batch.
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
    std::int32_t camera_revision = 0;  ///< revision of the camera for all poses so far
    std::int64_t examined_id = 0;      ///< newest keyframe examined with this revision; the cursor is for any revision
    std::int64_t strip_id = 0;         ///< 0: no strip is open
    std::int64_t posed_keyframe_id = 0;  ///< newest keyframe of the strip that has a pose or waits for it
    std::uint32_t failures = 0;          ///< failures in a row
    bool lost = false;                   ///< the strip was abandoned: its later keyframes have no pose
    bool end_commanded = false;          ///< the end of the lost strip was commanded
    ScaleSource scale_source = ScaleSource::first_baseline;
    BaselineErrors baseline_errors;  ///< for a rolling shutter
    double last_from_posed[9] = {1, 0, 0, 0, 1,
                                 0, 0, 0, 1};  ///< predicts pixels of the posed keyframe in the last keyframe examined
  };
  struct Work {
    CameraRecord camera;
    // The keyframe that is processed; a restart discards it.
    Phase phase = Phase::idle;
    KeyframeRecord keyframe;
    ShutterRecord shutter;         ///< motion of the keyframe's image, if the camera has a rolling shutter
    bool on_record = false;        ///< the keyframe has a pose from before the checkpoint was damaged
    bool newest_is_poor = false;   ///< the newest posed keyframe has few points and is tried last
    std::uint32_t attempt = 0;     ///< number of posed keyframes that were tried before
    std::size_t detected = 0;      ///< number of detected corners, without those from tracking
    SequenceReport newest_report;  ///< report on the relation to the newest posed keyframe
    std::int64_t subject = 0;      ///< input of the step for Patience: the keyframe, or the end of a strip
    Patience patience;
    bool keeps = false;  ///< the search for corners or matches continues in the shared memory
  };
  struct Workspace {
    double predicted[9]{};  ///< homography that predicts pixels of the earlier keyframe in this one
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
  /// The posed keyframe that is tried now, as its number of posed keyframes before the newest one.
  [[nodiscard]] std::uint32_t back() const;
  /// Moves on to the next posed keyframe to try. Returns false if there is none.
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
