// The cyclic executive: calls the components of a static table in fixed minor frames, gives what is left of a frame to
// whoever has pending work, counts overruns, restarts what failed, and knows no concrete component.
#pragma once

#include <array>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/executive/event_log.hpp"
#include "fsw/executive/overrun_reports.hpp"
#include "fsw/executive/work_level.hpp"
#include "fsw/records/records.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

class Executive final : public Health {
 public:
  /// `components` in the order of `stages`; both outlive the executive.
  Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock);

  /// Time passes while components work: housekeeping is written every so often, and the level of work follows the load,
  /// as [executive] of `mission` says, which outlives the executive. Before start(); in virtual time not at all.
  void keep_real_time(const MissionParameters& mission) { mission_ = &mission; }
  /// Restores every component; all of them are woken once.
  Status start();
  /// One minor frame, which should begin at `nominal` and end a minor frame later: every due component once in table
  /// order and woken ones between them, then pending work as long as it fits. What would not fit by the time that its
  /// steps took lately waits, and is the first to go in the next frame, so that nobody starves. In virtual time the
  /// frame ends when nothing is pending. Does not sleep: the caller's clock decides when the next frame begins.
  void run_minor_frame(TimeNs nominal);
  void run_minor_frame() { run_minor_frame(clock_.now()); }
  /// Nothing is pending but the time-driven components.
  [[nodiscard]] bool idle() const;

  [[nodiscard]] const ComponentStats& stats(ComponentId component) const override {
    return slots_[static_cast<std::size_t>(component)].stats;
  }
  [[nodiscard]] std::uint32_t frame_overruns() const override { return timing_.overruns; }
  [[nodiscard]] std::int64_t frames_run() const override { return frame_; }
  EventLog& events() { return events_; }
  [[nodiscard]] const TimingRecord& timing() const { return timing_; }
  /// Writes one ComponentRecord per component, and the TimingRecord.
  Status write_housekeeping();

 private:
  struct Slot {
    bool pending = false;
    bool suspended = false;             ///< has to wait for the next minor frame
    std::uint32_t faults_in_a_row = 0;  ///< in this minor frame
    std::int64_t retry_frame = 0;       ///< found the store full: woken again in this minor frame; 0: did not
    TimeNs expected_ns = 0;             ///< mission time that a step takes, by the longest of late
    std::uint32_t left_out = 0;         ///< in so many frames since its last step, because it would not have fitted
    bool counted = false;               ///< ... this one included
    ComponentStats stats;
  };

  void wake();
  /// Components that the ground wants to go back to their checkpoints.
  void obey_commands();
  void wait_for_store(Slot& slot) const;
  void run_step(std::size_t i, TimeNs deadline);
  /// Unasked work: if it fits, or has waited for longest, or is the first of its frame.
  bool run_woken(std::size_t i, TimeNs deadline);
  [[nodiscard]] std::size_t longest_left_out() const;
  void run_pending(TimeNs deadline);
  void end_frame(TimeNs nominal, TimeNs begin);
  void count_load(TimeNs now, TimeNs over);
  void judge_load(TimeNs now);
  Status measure_backlog(Backlog& backlog);
  Status take_up_level();
  Status write_timing();
  void restart(std::size_t i);

  std::span<const Stage> stages_;
  std::span<Component* const> components_;
  Store& store_;
  Clock& clock_;
  EventLog events_;
  std::array<Slot, limits::max_components> slots_{};
  std::int64_t frame_ = 0;
  static constexpr std::size_t nobody = limits::max_components;
  std::size_t first_ = nobody;  ///< has waited for longest to fit into a frame: runs in this one
  bool woken_ran_ = false;      ///< in this frame
  TimingRecord timing_;
  OverrunReports overruns_;
  const MissionParameters* mission_ = nullptr;  ///< null in virtual time
  TimeNs housekeeping_ns_ = 0;                  ///< last written
  WorkLevel work_level_;
  LoadWindow window_;
  std::int64_t obeyed_command_id_ = 0;
};

}  // namespace ilp
