// Assigns the vehicle's measurements to keyframes, and estimates the frame of each strip from them and from fixes on a
// map: Keyframe -> Navigation; Pose and Fix -> StripFrame.
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

/// If the mission uses navigation, the component keeps the newest samples and writes for each keyframe a record with
/// the measurements at its exposure. The record may be empty, but is always written, because structure and motion waits
/// for it. As the poses of a strip become final, the component estimates the strip frame: the similarity from the
/// strip's world frame to metres, up and north. Without navigation and map it uses the heights that come with the
/// images, if there are any. With a map, a pose is used only when the keyframe's fix is on record. Samples that are
/// implausible or out of order are left out and counted.
class Navigator final : public StageComponent<ComponentId::navigator> {
 public:
  static const CheckpointForm checkpoint;

  /// `source` is null if nothing is measured.
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
  /// The strip that is processed.
  struct State {
    std::int64_t strip_id = 0;
    bool placed = false;  ///< the origin is known
    BodyPlace origin;     ///< origin of the positions of the keyframes
    StripFrameVerdict verdict = StripFrameVerdict::nothing_measured;
    navigation::MeasuredKeyframes keyframes;
  };
  struct Workspace {
    State after;
    // A ring: a restart begins it again.
    FixedVector<NavigationSample, limits::max_navigation_samples> samples;
    std::size_t oldest = 0;
    std::int64_t refused = 0, reported_refused = 0;
    StatusCode reason = StatusCode::ok;  ///< why the latest refused sample was refused
  };

  StepResult work();
  /// Takes a bounded number of samples up to a time. Returns true if no more samples up to that time are left.
  bool take_samples(TimeNs until);
  void keep(const NavigationSample& sample);
  /// Writes the navigation record of the next keyframe. Returns false if there was nothing to do.
  Result<bool> measure_keyframe();
  /// Adds the next pose to its strip and writes the strip frame. Returns false if there was nothing to do.
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
  Cursor cursor_;  ///< newest keyframe with a navigation record; newest pose that was used
  State state_;
  Workspace workspace_;
};

}  // namespace ilp
