// Place recognition: recognises ground that an earlier keyframe of the flight has seen. Depth -> Place, Link, Tie, and
// the mask of new ground (docs/one-map.md).
#pragma once

#include "fsw/places/place_links.hpp"
#include "fsw/places/place_marks.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// Every keyframe with a depth record gets a place, in the order of keyframes. First its features are compared with
/// those of earlier keyframes: keyframes that are near it in tied strips, and keyframes with a similar appearance. A
/// keyframe that shows the same ground gets a link. Ground that earlier keyframes, found by links or in the same strip,
/// have seen at least as well is removed from the mask of new ground. A keyframe whose image or maps cannot be read
/// gets a place without features, and its mask is not changed. After a start all places are read from the store into
/// memory before the next keyframe is processed; a place that cannot be read is erased. The number of places is limited
/// (place_capacity.hpp).
class PlaceMemory final : public StageComponent<ComponentId::place_memory> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = PlaceStepScratch;

  PlaceMemory(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override;

 private:
  using Phase = PlacePhase;
  using State = PlaceState;
  using Features = PlacePart::Features;

  Status advance();
  Result<bool> pick();
  Status load_cells();
  void give_depths();
  Status load();
  Status find_features();
  Status take_patches();
  [[nodiscard]] std::size_t choose_slot(PlaceRecord& place) const;
  Status write_place(const PlaceRecord& place, std::size_t forgotten);
  Status write_ties(State& after);
  void remember(const PlaceRecord& place, std::size_t forgotten);
  Status record();
  template <typename Part>
  Part part() {
    return Part(wiring_, cursor_, work_, workspace_);
  }

  PlaceWiring wiring_;
  Cursor cursor_;
  State state_;
  PlaceWork work_;
  PlaceWorkspace workspace_;
};

}  // namespace ilp
