// Registers keyframes against the map of an orbiter: Depth and the tiles of the map -> Fix (docs/map-relative.md).
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/localisation/map_part.hpp"

namespace ilp {

/// Does nothing unless the mission uses a map. Every keyframe with a depth record gets a record `fix`, in the order of
/// keyframes; the record of a keyframe that cannot be localised gives the reason. The prior of the registration is
/// predicted from the latest fixes of the strip, or from the vehicle's measurements. A fix that is farther from the
/// prior than the prior's error allows is accepted only if the next fix agrees. The prior depends only on records that
/// never change and on the component's own state, so that the results do not depend on the time of its steps.
class MapFix final : public StageComponent<ComponentId::map_fix> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = MapStepScratch;

  /// `source` is null if there is no map.
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
