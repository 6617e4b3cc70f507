// The components of a process in the order of their stages, and the state that their executive keeps.
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

/// Whether the primary waits for the stage's results on an image before it takes the next image, if several processes
/// share a flight in virtual time (bsp/flight/held_camera.hpp).
[[nodiscard]] constexpr bool others_wait_for(const Stage& stage) {
  using enum RecordType;
  return stage.runs_on == RunsOn::any && (stage.writes & mask_of(overlap, calibration, pose)) != 0;
}

/// Options of an executive. The objects must outlive it.
struct ExecutiveSetup {
  /// The mission parameters. They change only in steps that report it (StepResult::set_parameters). The executive
  /// reverts any other change at the end of a step or before the next step.
  MissionParameters* parameters = nullptr;
  /// Real time: time passes while components work. Housekeeping is written periodically, and the work level follows the
  /// load, as the parameters of [executive] say. False in virtual time.
  bool real_time = false;
  bool shares_flight = false;                 ///< other processes run the rest of the schedule
  StepStore* steps = nullptr;                 ///< the store through which the components write
  std::span<const std::byte> constants = {};  ///< memory that never changes after start(); a change needs a new process
};

struct ComponentSlot {
  /// The transitions are in docs/design.md.
  enum class Activity : std::uint8_t {
    stopped,  ///< before start()
    waiting,  ///< its restore() failed, which was reported; the next attempt is in `hold_frame` or later
    idle,     ///< nothing to do until it is woken
    ready,    ///< it has work
    full      ///< the store was full: it is ready again in `retry_frame`, or when it is woken
  };

  Activity activity = Activity::stopped;
  bool suspended = false;             ///< no further step in this minor frame
  std::uint32_t faults_in_a_row = 0;  ///< faults in this minor frame since its last successful step
  std::int64_t retry_frame = 0;
  std::int64_t hold_frame = 0;        ///< after a transient fault: it neither steps nor is restored before this frame
  std::int64_t pause = 0;             ///< the latest pause, in minor frames
  std::int64_t attempts = 0;          ///< failed attempts to restore it
  TimeNs expected_ns = 0;             ///< expected duration of a step in mission time, from the longest recent steps
  std::uint32_t left_out = 0;         ///< frames since its last step in which it had work that did not fit
  bool counted = false;               ///< `left_out` includes the present frame
  std::uint64_t checksum = 0;         ///< checksum of cursor, state and work after its last step
  std::uint64_t state_checksum = 0;   ///< checksum of cursor and state
  std::uint64_t wiring_checksum = 0;  ///< checksum of the parts that never change
  bool sealed = false;                ///< `wiring_checksum` is valid
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
  TimeNs housekeeping_ns = 0;  ///< when housekeeping was last written
  WorkLevel work_level;
  LoadWindow window;
  std::int64_t obeyed_command_id = 0;
  std::size_t keeper = limits::max_components;  ///< index of the component that keeps the shared memory; or `nobody`
  bool taken_up = false;                        ///< take_up() has succeeded
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
  bool restart_wanted = false;   ///< damaged memory can be restored only by a new process
  bool late_work_waits = false;  ///< see Executive::put_off
  LockTimes lock = {};           ///< the store's lock, as steps have found it

  [[nodiscard]] ComponentSlot& slot(std::size_t i) { return own.slots[i]; }
  [[nodiscard]] const ComponentSlot& slot(std::size_t i) const { return own.slots[i]; }
  [[nodiscard]] std::int64_t number_of(std::size_t i) const { return static_cast<std::int64_t>(stages[i].component); }
  /// Index of the component with this number; `nobody` if there is none.
  [[nodiscard]] std::size_t place_of(std::int64_t number) const {
    for (std::size_t i = 0; i < stages.size(); ++i) {
      if (number_of(i) == number) return i;
    }
    return nobody;
  }
  /// Whether this process is the primary, which has the camera and the links.
  [[nodiscard]] bool leads() const { return !stages.empty() && number_of(0) == TimingRecord{}.id; }
  /// Whether component `i` may use the shared memory, or does not need it.
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
  /// Whether component `i` waits because of Executive::put_off.
  [[nodiscard]] bool is_put_off(std::size_t i) const {
    return late_work_waits && stages[i].period == 0 && !others_wait_for(stages[i]);
  }
  /// The present mission parameters were changed on purpose.
  void accept_parameters() {
    if (setup.parameters != nullptr) parameters_guard.seal(*setup.parameters);
  }
  void report(const Status& event) { events.report(clock.now(), "executive", event); }
  /// Reports an event of component `i`.
  void report_of(std::size_t i, const Status& event) { events.report(clock.now(), components[i]->name(), event); }
};

}  // namespace ilp
