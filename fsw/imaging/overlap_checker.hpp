// Selects the keyframes from the frames: Frame -> Keyframe (paper 3.1; decisions.md, 1).
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

/// A frame becomes the next keyframe if it is the first one at or below the target overlap with the latest keyframe, if
/// much of it is new because the camera climbs, or if it sees the ground from a far different position.
///
/// If the overlap of a frame is already too small, the candidate (the frame before it) becomes the keyframe instead,
/// provided that its overlap suffices. Otherwise the frame is matched with the latest keyframe by oriented features; it
/// becomes the next keyframe if the common ground suffices to continue the structure. If it does not match the latest
/// keyframe, which may be a bad image, it is matched with the keyframe before the latest one, and becomes the next
/// keyframe at once if it matches there. If it matches neither, the strip ends and a new one begins.
///
/// A frame that cannot be compared (dark, blurred, without texture) is left out. Two frames in a row that have texture
/// but match nothing end the strip, and the first of them begins the next one. No strip begins with a frame that cannot
/// be compared. A frame of a burst is compared with the keyframe, but is not selected. A frame that cannot be read is
/// left out. If the keyframe cannot be read, the strip ends and the next frame begins another one. If the checkpoint is
/// older than the records, the open strip ends too.
class OverlapChecker final : public StageComponent<ComponentId::overlap_checker> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = StepScratch<OverlapWorkspace, FeatureOverlapWorkspace, PlaceScratch>;

  /// `compute` carries out the jobs of the wide search. If it is null, there is no wide search.
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
  /// The latest measured frame that was not selected. It is selected if the overlap of the next frame is too small.
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
    std::int64_t index = 0;             ///< index of the next keyframe in its strip
    std::int64_t unknown_frame_id = 0;  ///< a frame that matched nothing and waits for the next frame; 0: none
    double last_rotation_rad = 0;       ///< rotation of the last frame relative to the keyframe
    double last_scale = 1;
    Candidate candidate;
    bool motion_known = false;  ///< some frame of this strip was measured
  };
  struct Work {
    Patience patience;                    ///< restore() keeps it
    bool keyframe_unreadable = false;     ///< found in this step
    std::int64_t unrelated_frame_id = 0;  ///< frame that does not match this keyframe, as the step before found
    std::int64_t unrelated_keyframe_id = 0;
    OverlapResult unrelated = {};  ///< result for that frame and that keyframe
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
    bool has_plane = false;  ///< only with a rolling shutter
    bool has_keyframe = false;
    bool has_ended = false;
    bool open = false;   ///< nothing is decided yet: the next step continues with the same frame
    bool waits = false;  ///< the frame waits for a compute device
    Status event = {};
  };

  /// Frames that were chosen after the checkpoint are not chosen again.
  Status resume_after_records();
  Status load_keyframe(std::int64_t frame_id);
  Status correlate(OverlapResult& measured);
  Result<bool> handle_command(Outcome& outcome);
  Status measure(const FrameRecord& frame, OverlapResult& measured);
  /// Runs one step of the wide search if `measured` is unknown.
  Status search_widely(const FrameRecord& frame, Outcome& outcome, OverlapResult& measured);
  /// Matches the frame with the latest keyframe by oriented features. Returns whether they share enough ground to
  /// continue the strip.
  Result<bool> relocalise(OverlapResult& measured);
  /// The same with the keyframe before the latest one, if the frame does not match the latest one.
  Result<bool> relocalise_across(OverlapResult& measured);
  /// How a frame is related to the open strip.
  enum class Relation : std::uint8_t {
    overlap,     ///< measured overlap with the latest keyframe, which may be unknown
    relocalise,  ///< oriented features match enough ground of the latest keyframe
    across_bad,  ///< oriented features match enough ground of the keyframe before the latest one
  };
  Result<Relation> relate(const FrameRecord& frame, Outcome& outcome, OverlapResult& measured);
  /// The decision on a frame.
  enum class Choice : std::uint8_t {
    rejected,         ///< it cannot be compared
    waits,            ///< it matches nothing of the strip, and waits for the next frame to confirm that
    waiting_begins,   ///< the frame that waited begins a strip, and this frame is then compared with it
    candidate_first,  ///< the candidate is selected, and this frame is then compared with it
    begins_strip,
    selected,
    skipped,
  };
  /// Decides on a frame while a strip is open, by the first rule that applies.
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
