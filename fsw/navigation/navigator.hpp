// Where keyframes and strips lie by the vehicle's own measurements and by fixes on a map: Keyframe -> Navigation, Pose
// and Fix -> StripFrame.
#pragma once

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/navigation/sample_filter.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"
#include "hal/clock/clock.hpp"
#include "hal/navigation/navigation.hpp"

namespace ilp {

/// With navigation it keeps the newest samples, and says for each keyframe what they mean at its exposure: also that it
/// is nothing, because structure and motion waits for that record. It says for each strip, as its poses become final,
/// which similarity takes its world to metres, up and north; without navigation and a map by the heights that come with
/// the images, if there are any. With a map, a pose waits for the keyframe's fix. Samples that are implausible or out
/// of order are left out and counted.
class Navigator final : public StageComponent<ComponentId::navigator> {
 public:
  static const CheckpointForm checkpoint;

  /// Without a source nothing is measured.
  Navigator(Tables store, Clock& clock, const MissionParameters& mission, NavigationSource* source = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, NoMembers{}, workspace_);
  }

 private:
  struct Wiring {
    Tables store;
    Clock& clock;
    const MissionParameters& mission;
    NavigationSource* source;
  };
  /// The strip at work.
  struct State {
    std::int64_t strip_id = 0;
    bool placed = false;  ///< the origin is known
    BodyPlace origin;     ///< from where the places of the keyframes are counted
    StripFrameVerdict verdict = StripFrameVerdict::nothing_measured;
    navigation::MeasuredKeyframes keyframes;
  };
  struct Workspace {
    State after;
    // A ring: a restart begins it again.
    FixedVector<NavigationSample, limits::max_navigation_samples> samples;
    std::size_t oldest = 0;
    std::int64_t refused = 0, reported_refused = 0;
    StatusCode reason = StatusCode::ok;  ///< why the latest one was refused
  };

  StepResult work();
  /// Takes samples up to a time, a bounded number of them. Returns whether there are no more up to that time.
  bool take_samples(TimeNs until);
  void keep(const NavigationSample& sample);
  /// Whether there was something to do, here and below.
  Result<bool> measure_keyframe();
  Result<bool> place_strip();
  void measure(const KeyframeRecord& keyframe, NavigationRecord& record) const;
  Result<bool> fixed_at(std::int64_t keyframe_id, FixRecord& fix) const;
  Status take_image_height(std::int64_t keyframe_id, NavigationRecord& measured) const;
  /// Whether the vehicle has measured nothing at any keyframe of the strip.
  [[nodiscard]] Result<bool> is_unmeasured(const State& strip) const;
  void add(const PoseRecord& pose, const NavigationRecord& navigation, const FixRecord& fix, State& after) const;
  BodyPlace place_on_plane(const navigation::StripFrame& frame, const State& after, StripFrameRecord& record) const;
  [[nodiscard]] StripFrameRecord record_of(const navigation::StripFrame& frame, const State& after,
                                           std::int64_t keyframe_id) const;

  Wiring wiring_;
  Cursor cursor_;  ///< newest keyframe measured, newest pose taken into account
  State state_;
  Workspace workspace_;
};

}  // namespace ilp
