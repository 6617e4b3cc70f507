// Computes the Image Richness Index of the newly seen part of a keyframe: Depth and Mask -> Richness (paper 4.1;
// decisions.md, 10).
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

/// The weights of the index from the mission parameters.
[[nodiscard]] RichnessParams richness_params(const MissionParameters& mission);

/// Processes one keyframe at a time, in slices: image, maps, depths, cues. A keyframe whose image or maps cannot be
/// read gets the index 0. If the checkpoint is older than the records, those keyframes are missing in the history.
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
    const LastingMemory memory = LastingMemory::of(*this, wiring_, cursor_, state_, work_).changed_by_commits();
    if (work_.phase < Phase::cues) return memory;
    const auto& w = wiring_.scratch.as<Workspace>();
    return memory.keeping(w.richness.part).keeping(w.cues);
  }

 private:
  enum class Phase : std::uint8_t { idle, image, maps, depth, cues, record };

  struct Wiring {
    Tables store;
    const MissionParameters& mission;
    Scratch scratch;
  };
  struct State {
    RichnessHistory history;
  };
  struct Work {
    Patience patience;
    CameraModel camera;
    // The keyframe that is processed; a restart discards it.
    DepthRecord depth;
    MaskRecord mask;
    RichnessRecord record;
    Phase phase = Phase::idle;
  };

  StepResult pick();
  Status load_image();
  Status decode_maps();
  Status score();
  Status advance();
  StepResult record(const Status& scored);

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
};

}  // namespace ilp
