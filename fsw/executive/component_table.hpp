// The components of a process in the order of their stages, and what their executive keeps.
#pragma once

#include <array>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/lock_times.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/executive/event_log.hpp"
#include "fsw/executive/overrun_reports.hpp"
#include "fsw/executive/step_store.hpp"
#include "fsw/executive/work_level.hpp"
#include "fsw/records/records.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The stages whose words on an image the primary waits for before it takes the next one, where several processes share
/// a flight in virtual time (bsp/flight/held_camera.hpp).
[[nodiscard]] constexpr bool others_wait_for(const Stage& stage) {
  using enum RecordType;
  return stage.runs_on == RunsOn::any && (stage.writes & mask_of(overlap, calibration, pose)) != 0;
}

/// What an executive may have. All of it outlives the executive.
struct ExecutiveSetup {
  /// Change only in steps that report it (StepResult). The executive reverts any other change at the end of a step or
  /// before the next one.
  MissionParameters* parameters = nullptr;
  /// Time passes while components work: housekeeping is written periodically, and the level of work follows the load,
  /// as [executive] of the parameters says. Never in virtual time.
  bool real_time = false;
  bool shares_flight = false;                 ///< other processes run the rest of the schedule
  StepStore* steps = nullptr;                 ///< the components write through it
  std::span<const std::byte> constants = {};  ///< never change from start() on; if they do, only a new process helps
};

struct ComponentSlot {
  /// docs/design.md draws the transitions.
  enum class Activity : std::uint8_t {
    stopped,  ///< before start()
    waiting,  ///< it could not be restored, which was reported; it is tried again from `hold_frame` on
    idle,     ///< nothing to do until it is woken
    ready,    ///< it has work
    full      ///< the store had no room for its work: it is ready again in `retry_frame`, or when it is woken
  };

  Activity activity = Activity::stopped;
  bool suspended = false;             ///< it steps no more in this minor frame
  std::uint32_t faults_in_a_row = 0;  ///< in this minor frame
  std::int64_t retry_frame = 0;
  std::int64_t hold_frame = 0;  ///< after a fault that may pass: it is neither woken nor restored before this frame
  std::int64_t pause = 0;       ///< the latest pause, in minor frames
  std::int64_t attempts = 0;    ///< failed attempts to restore it
  TimeNs expected_ns = 0;       ///< expected mission time of a step, by the longest of recent ones
  std::uint32_t left_out = 0;   ///< frames since its last step in which it would not have fitted
  bool counted = false;         ///< the present frame is among them
  std::uint64_t checksum = 0;   ///< of its lasting memory, after its last step
  std::uint64_t state_checksum = 0;   ///< of cursor and state alone
  std::uint64_t wiring_checksum = 0;  ///< of what in it never changes
  bool sealed = false;                ///< the checksums are known
  ComponentStats stats;

  [[nodiscard]] bool restored() const { return activity > Activity::waiting; }
  void wake() {
    if (restored()) activity = Activity::ready;
  }
};
/// State that lasts from one minor frame to the next.
struct ExecutiveState {
  std::array<ComponentSlot, limits::max_components> slots{};
  std::int64_t frame = 0;
  TimingRecord timing;
  OverrunReports overruns;
  TimeNs housekeeping_ns = 0;  ///< last written
  WorkLevel work_level;
  LoadWindow window;
  std::int64_t obeyed_command_id = 0;
  std::size_t keeper = limits::max_components;  ///< the component whose work goes on in the shared memory
  bool taken_up = false;                        ///< numbers and level of the previous boot are loaded
  std::uint64_t constants_checksum = 0;
};

struct ComponentTable {
  static constexpr std::size_t nobody = limits::max_components;

  std::span<const Stage> stages;
  std::span<Component* const> components;
  Store& store;
  Clock& clock;
  const ExecutiveSetup setup;
  EventLog events{store};
  ExecutiveState own = {};
  Guarded<ExecutiveState> own_guard = {};
  Guarded<MissionParameters> parameters_guard = {};
  bool restart_wanted = false;  ///< memory was damaged that only a new process restores
  bool late_work_waits = false;
  LockTimes lock = {};  ///< of the store, as steps have found it

  [[nodiscard]] ComponentSlot& slot(std::size_t i) { return own.slots[i]; }
  [[nodiscard]] const ComponentSlot& slot(std::size_t i) const { return own.slots[i]; }
  [[nodiscard]] std::int64_t number_of(std::size_t i) const { return static_cast<std::int64_t>(stages[i].component); }
  /// Where the component with this number stands in the table; or `nobody`.
  [[nodiscard]] std::size_t place_of(std::int64_t number) const {
    for (std::size_t i = 0; i < stages.size(); ++i) {
      if (number_of(i) == number) return i;
    }
    return nobody;
  }
  /// This process has the camera and the links.
  [[nodiscard]] bool leads() const { return !stages.empty() && number_of(0) == TimingRecord{}.id; }
  [[nodiscard]] bool memory_is_free(std::size_t i) const {
    return own.keeper == nobody || own.keeper == i || !stages[i].step_memory;
  }
  [[nodiscard]] bool may_run(std::size_t i) const {
    return slot(i).restored() && !slot(i).suspended && !lock.taken() && own.frame >= slot(i).hold_frame &&
           memory_is_free(i);
  }
  [[nodiscard]] bool has_work(std::size_t i) const {
    return slot(i).activity == ComponentSlot::Activity::ready && may_run(i);
  }
  [[nodiscard]] bool is_put_off(std::size_t i) const {
    return late_work_waits && stages[i].period == 0 && !others_wait_for(stages[i]);
  }
  void accept_parameters() {
    if (setup.parameters != nullptr) parameters_guard.seal(*setup.parameters);
  }
  void report(const Status& event) { events.report(clock.now(), "executive", event); }
  void report_of(std::size_t i, const Status& event) { events.report(clock.now(), components[i]->name(), event); }
};

}  // namespace ilp
