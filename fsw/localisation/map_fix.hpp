// Where keyframes stand on the map of an orbiter: Depth and the tiles of the map -> Fix (docs/map-relative.md).
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/localisation/map_part.hpp"

namespace ilp {

/// Does nothing unless the mission uses a map. Every keyframe with a depth record gets a fix, in the order of
/// keyframes; one that cannot be localised gets a record that says why. A keyframe is registered where the latest fixes
/// of its strip lead, or where the vehicle's measurements say. A fix that is farther from there than that errs counts
/// only if the next one agrees. What it predicts follows from records that never change and from its own state, so that
/// the same flight gives the same fixes whenever its steps come.
class MapFix final : public StageComponent<ComponentId::map_fix> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = MapStepScratch;

  /// Without a source there is no map.
  MapFix(Tables store, const MissionParameters& mission, Scratch scratch, MapSource* source = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override;

 private:
  using Phase = MapPhase;
  using State = MapState;

  Result<bool> pick();
  Status advance();
  Status load();
  Status load_depths();
  Status measure();
  Status survey();
  void predict_by_fixes(const navigation::StripFrame& by_vehicle);
  bool predict_by_vehicle(const navigation::StripFrame& frame);
  bool find_ground(const Vec3& place);
  Status plan();
  Status paint();
  Status begin_search();
  Status search();
  void conclude(MapVerdict verdict);
  Status record();
  void take_result(const MapFixResult& result);
  void judge(const MapFixResult& result);
  void state_place();
  [[nodiscard]] SunDirection sun() const;
  MapPart part() { return {wiring_, work_, workspace_}; }
  MapFixScratch& scratch() { return wiring_.scratch.as<MapFixScratch>(); }

  MapWiring wiring_;
  Cursor cursor_;  ///< newest keyframe with a fix on record
  MapState state_;
  MapWork work_;
  MapWorkspace workspace_;
};

}  // namespace ilp
