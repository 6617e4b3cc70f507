// The interest of the newly seen part of a keyframe: Depth and Mask -> Richness (paper 4.1; decisions.md, 10).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/products/depth_access.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/terrain/richness.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// The weights of this mission.
[[nodiscard]] RichnessParams richness_params(const MissionParameters& mission);

/// Processes one keyframe at a time, in slices: its image, its maps, the depths in them, and its cues. A keyframe whose
/// image or maps cannot be read is rated 0. If the checkpoint is older than the records, the history
/// misses those keyframes.
class RichnessScorer final : public StageComponent<ComponentId::richness_scorer> {
 public:
  static const CheckpointForm checkpoint;

  struct Workspace {
    FrameImage image;
    MapBuffers maps;
    FixedImage<float, limits::max_image_pixels> inverse_depth, sigma;
    RichnessWorkspace richness;
    RichnessCues cues;
  };
  using Scratch = StepScratch<Workspace>;

  RichnessScorer(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    const LastingMemory memory =
        LastingMemory(cursor_, state_).of(*this).at_work(patience_, phase_).changed_by_commits();
    if (phase_ < Phase::cues) return memory;
    const auto& w = scratch_.as<Workspace>();
    return memory.keeping(w.richness.part, w.cues);
  }

 private:
  struct State {
    RichnessHistory history;
  };

  enum class Phase : std::uint8_t { idle, image, maps, depth, cues, record };

  StepResult pick();
  Status load_image();
  Status decode_maps();
  Status score();
  Status advance();
  StepResult record(const Status& scored);

  Tables store_;
  const MissionParameters& mission_;
  Scratch scratch_;
  Cursor cursor_;
  State state_;
  Patience patience_;
  CameraModel camera_;
  // The keyframe at work; a restart drops it.
  DepthRecord depth_;
  MaskRecord mask_;
  RichnessRecord record_;
  Phase phase_ = Phase::idle;
};

}  // namespace ilp
