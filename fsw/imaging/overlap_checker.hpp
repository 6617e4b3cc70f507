// Chooses which frames are worth processing: Frame -> Keyframe (paper 3.1; decisions.md, 1).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/imaging/wide_overlap.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// The first frame at or below the target overlap with the latest keyframe becomes the next keyframe, and so does one
/// of which much is new because the camera climbs, and one that sees the ground from far elsewhere. If a frame has
/// moved too far already, the frame before it is taken instead, provided that its overlap suffices; otherwise oriented
/// features relate it, and it becomes the next keyframe if the structure can go on from the common ground. If nothing
/// relates it to the latest keyframe, which may be a bad image, the same features are compared with the keyframe before
/// it; a frame that they relate to that one becomes the next keyframe at once. If not, the strip ends and a new one
/// begins. A frame that cannot be compared (dark, blurred, without texture) is left out. Two in a row that have texture
/// but match nothing end the strip, and the first of them begins the next one. No strip begins with a frame that cannot
/// be compared. A frame of a burst is compared with the keyframe, and decides nothing. A frame that cannot be read is
/// left out. If the keyframe cannot be read, the strip ends and the next
/// frame begins another one. If the checkpoint is older than the records, the open strip ends too.
class OverlapChecker final : public StageComponent<ComponentId::overlap_checker> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = StepScratch<OverlapWorkspace, FeatureOverlapWorkspace, PlaceScratch>;

  /// `compute` does the jobs of the wide search; without it there is none.
  OverlapChecker(Tables store, const MissionParameters& mission, Scratch scratch, Compute* compute = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  }

 private:
  struct Wiring {
    Tables store;
    const MissionParameters& mission;
    Scratch scratch;
    Compute* compute;
  };
  /// Candidate: the latest frame that was measured and is not yet needed.
  struct Candidate {
    std::int64_t frame_id = 0;
    double overlap = 0;
    double plane_from_keyframe[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  };
  struct State {
    std::int64_t strip_id = 0;  ///< 0: no strip is open
    std::int64_t last_strip_id = 0;
    std::int64_t last_keyframe_id = 0;
    std::int64_t keyframe_id = 0;  ///< latest keyframe of the open strip; 0: none
    std::int64_t keyframe_frame_id = 0;
    std::int64_t index = 0;             ///< of the next keyframe in its strip
    std::int64_t unknown_frame_id = 0;  ///< a frame that matched nothing, until the next frame confirms it; 0: none
    double last_rotation_rad = 0;       ///< of the last frame against the keyframe
    double last_scale = 1;
    Candidate candidate;
    bool motion_known = false;  ///< some frame of this strip was measured
  };
  struct Work {
    Patience patience;                    ///< restore() keeps it
    bool keyframe_unreadable = false;     ///< as found in this step
    std::int64_t unrelated_frame_id = 0;  ///< not related to the latest keyframe; the step before found so
    std::int64_t unrelated_keyframe_id = 0;
    OverlapResult unrelated = {};  ///< of that frame and that keyframe
    std::int64_t loaded_frame_id = 0;
  };
  struct Workspace {
    FrameImage keyframe_image;
    OverlapTemplate keyframe;  ///< template of that image
    FrameImage image;
    WideOverlap wide;
  };
  /// The decisions of one step, written in one transaction.
  struct Outcome {
    State after = {};
    Cursor cursor = {};
    OverlapRecord overlap = {};
    FramePlaneRecord plane = {};
    KeyframeRecord keyframe = {};
    StripRecord ended = {};
    StripRecord strip = {};
    bool has_overlap = false;
    bool has_plane = false;  ///< of a rolling shutter
    bool has_keyframe = false;
    bool has_ended = false;
    bool open = false;   ///< nothing is decided yet: the next step goes on with the frame
    bool waits = false;  ///< for a compute device
    Status event = {};
  };

  /// Frames that were chosen after the checkpoint are not chosen again.
  Status resume_after_records();
  Status load_keyframe(std::int64_t frame_id);
  Status correlate(OverlapResult& measured);
  Result<bool> handle_command(Outcome& outcome);
  Status measure(const FrameRecord& frame, OverlapResult& measured);
  /// The wide search where `measured` is unknown, one step of it at a time.
  Status search_widely(const FrameRecord& frame, Outcome& outcome, OverlapResult& measured);
  /// Whether the keyframe is related to the frame, and shares enough ground with it to continue the strip.
  Result<bool> relocalise(OverlapResult& measured);
  /// Whether the keyframe before the latest one is, where the latest one is not.
  Result<bool> relocalise_across(OverlapResult& measured);
  /// What relates a frame to the open strip.
  enum class Relation : std::uint8_t {
    overlap,     ///< with the latest keyframe, by correlation or features; or nothing does
    relocalise,  ///< too far for that, but oriented features relate it to enough ground of the latest keyframe
    across_bad,  ///< the same with the keyframe before the latest one
  };
  Result<Relation> relate(const FrameRecord& frame, Outcome& outcome, OverlapResult& measured);
  /// What becomes of a frame.
  enum class Choice : std::uint8_t {
    rejected,         ///< it cannot be compared
    waits,            ///< nothing relates it to the strip; the next frame confirms that
    waiting_begins,   ///< the frame that waited begins a strip, and this one is compared with it
    candidate_first,  ///< the frame before it is selected, and this one is compared with that
    begins_strip,
    selected,
    skipped,
  };
  /// A frame beside an open strip, by the first rule that applies.
  [[nodiscard]] Choice classify(const OverlapResult& measured, Relation relation) const;
  Status apply(Choice choice, const FrameRecord& frame, const OverlapResult& measured, Outcome& outcome) const;
  Status look_alone(const FrameRecord& frame, Outcome& outcome);
  Status evaluate(const FrameRecord& frame, Outcome& outcome);
  void select(const FrameRecord& frame, const OverlapResult& measured, Outcome& outcome) const;
  void begin_strip(const FrameRecord& frame, Outcome& outcome) const;
  void end_strip(StripEnd reason, Outcome& outcome) const;
  Result<bool> begin_strip_of_waiting(Outcome& outcome) const;
  Status select_candidate(Outcome& outcome) const;
  Status load_strip(const Outcome& outcome, std::int64_t id, StripRecord& strip);
  Status write(Outcome& outcome);
  StepResult choose(const Status& found, const FrameRecord& frame, Outcome& outcome);

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
