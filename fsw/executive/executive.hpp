// The cyclic executive: calls the components of a static table in fixed minor frames, gives the rest of a frame to
// components with pending work, counts overruns and restarts what failed. It knows no concrete component. A component
// steps only if it has been restored and its memory has not changed since its last step. While another process keeps
// the lock of the store, the others would work in vain, and only the time-driven ones step, when they are due.
#pragma once

#include <array>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/executive/event_log.hpp"
#include "fsw/executive/overrun_reports.hpp"
#include "fsw/executive/step_store.hpp"
#include "fsw/executive/work_level.hpp"
#include "fsw/records/records.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The stages whose words on an image the head waits for before it takes the next one, where several processes share a
/// flight in virtual time (bsp/flight/held_camera.hpp).
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

class Executive final : public Health {
 public:
  /// `components` in the order of `stages`, which may be a part of the schedule; both outlive the executive.
  Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock,
            const ExecutiveSetup& setup = {});

  /// The guarded parameters were changed between two steps on purpose: other processes share the flight, and a setting
  /// came from one of them.
  void accept_parameters() {
    if (setup_.parameters != nullptr) parameters_guard_.seal(*setup_.parameters);
  }
  /// While it is set, a stage that runs only when woken waits, unless others_wait_for() it. For virtual time only.
  void put_off(bool late_work) { late_work_waits_ = late_work; }
  /// Restores every component and wakes each of them once. A component that cannot be restored now waits and is tried
  /// again. Only faults that waiting cannot heal are returned: `store_build`, `store_schema`, `store_damaged`.
  Status start();
  /// Every component looks for work in the next minor frame, whatever was reported about changes.
  void wake_all() {
    for (std::size_t i = 0; i < stages_.size(); ++i) own_.slots[i].wake();
    seal_own();
  }
  /// Runs one minor frame, which should begin at `nominal` and end a minor frame later: every due component once in
  /// table order and woken ones between them, then pending work as long as it fits. A step whose recent durations would
  /// not fit waits, and is the first of the next frame, so that no component starves. A component that keeps the shared
  /// memory steps again at once, or is the first of the next frame; the others that use this memory wait. In virtual
  /// time the frame ends when nothing is pending. It does not sleep: the caller's clock decides when the next frame
  /// begins.
  void run_minor_frame(TimeNs nominal);
  void run_minor_frame() { run_minor_frame(clock_.now()); }
  /// No component but the time-driven ones has pending work.
  [[nodiscard]] bool idle() const;

  [[nodiscard]] const ComponentStats& stats(ComponentId component) const override {
    static constexpr ComponentStats none;
    const std::size_t place = place_of(static_cast<std::int64_t>(component));
    return place == nobody ? none : own_.slots[place].stats;
  }
  [[nodiscard]] bool runs(ComponentId component) const override {
    return place_of(static_cast<std::int64_t>(component)) != nobody;
  }
  [[nodiscard]] std::uint32_t frame_overruns() const override { return own_.timing.overruns; }
  [[nodiscard]] std::int64_t frames_run() const override { return own_.frame; }
  EventLog& events() { return events_; }
  [[nodiscard]] const TimingRecord& timing() const { return own_.timing; }
  /// Memory was damaged that only a new process restores.
  [[nodiscard]] bool restart_wanted() const { return restart_wanted_; }
  /// Writes one ComponentRecord per component, and the TimingRecord.
  Status write_housekeeping();
  /// The flight ends: also reports events that were only counted so far.
  Status end() {
    events_.report_rest(clock_.now());
    return write_housekeeping();
  }

 private:
  static constexpr std::size_t nobody = limits::max_components;

  /// docs/design.md draws the transitions.
  enum class Activity : std::uint8_t {
    stopped,  ///< before start()
    waiting,  ///< it could not be restored, which was reported; it is tried again from `hold_frame` on
    idle,     ///< nothing to do until it is woken
    ready,    ///< it has work
    full      ///< the store had no room for its work: it is ready again in `retry_frame`, or when it is woken
  };
  struct Slot {
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
  struct Own {
    std::array<Slot, limits::max_components> slots{};
    std::int64_t frame = 0;
    TimingRecord timing;
    OverrunReports overruns;
    TimeNs housekeeping_ns = 0;  ///< last written
    WorkLevel work_level;
    LoadWindow window;
    std::int64_t obeyed_command_id = 0;
    std::size_t keeper = nobody;  ///< the component whose work goes on in the shared memory
    bool taken_up = false;        ///< numbers and level of the previous life are loaded
    std::uint64_t constants_checksum = 0;
  };

  [[nodiscard]] std::int64_t number_of(std::size_t i) const { return static_cast<std::int64_t>(stages_[i].component); }
  /// Where the component with this number stands in the table; or `nobody`.
  [[nodiscard]] std::size_t place_of(std::int64_t number) const;
  void wake();
  /// Restores the components that the ground has commanded back to their checkpoints.
  void obey_commands();
  /// A step has found the lock of the store taken.
  void wait_for_lock(Slot& slot);
  void look_at_lock();
  /// A fault in the executive's own use of the store.
  void report_own(const Status& status);
  void hold(Slot& slot) const;
  [[nodiscard]] bool memory_is_free(std::size_t i) const {
    return own_.keeper == nobody || own_.keeper == i || !stages_[i].step_memory;
  }
  [[nodiscard]] bool may_run(std::size_t i) const {
    const Slot& slot = own_.slots[i];
    return slot.restored() && !slot.suspended && !store_locked_ && own_.frame >= slot.hold_frame && memory_is_free(i);
  }
  [[nodiscard]] bool has_work(std::size_t i) const { return own_.slots[i].activity == Activity::ready && may_run(i); }
  /// Returns false, and reports it once, if the component has to wait.
  bool restore(std::size_t i, Status& status);
  void seal(std::size_t i, const LastingMemory& memory, std::uint64_t state);
  /// Returns false, after a restore, if its memory has changed since its last step.
  bool sound(std::size_t i, const LastingMemory& memory);
  /// Restores the component from its checkpoint, because its memory is damaged.
  void go_back(std::size_t i);
  void check_own();
  void check_parameters();
  void check_constants();
  void seal_own() { own_guard_.seal(own_); }
  /// Checks its memory, lets it step, and does what the result asks for.
  void run_step(std::size_t i);
  /// The step itself, with its times. `memory` is what lasted before it. False in `intact`: its memory has changed, and
  /// a commit was refused because of that.
  StepResult take_step(std::size_t i, const LastingMemory& memory, bool& intact);
  void count_step(std::size_t i, TimeNs used_ns);
  void follow(std::size_t i, const StepResult& result);
  /// Returns whether it was restarted.
  bool follow_fault(std::size_t i, const Status& status);
  /// Whether its next step is expected to end before the deadline, with `reserved` to spare.
  [[nodiscard]] bool fits(std::size_t i, TimeNs reserved, TimeNs deadline);
  /// Runs a step, and the next ones while it keeps the shared memory and they fit.
  void run_work(std::size_t i, TimeNs deadline);
  /// Runs a woken component if it fits, has waited for longest, or is the first of its frame.
  bool run_woken(std::size_t i, TimeNs deadline);
  [[nodiscard]] std::size_t longest_left_out() const;
  [[nodiscard]] bool is_put_off(std::size_t i) const {
    return late_work_waits_ && stages_[i].period == 0 && !others_wait_for(stages_[i]);
  }
  /// Steps the stages that others wait for as long as they have work that fits. Returns whether there was any.
  bool run_awaited(TimeNs deadline, std::uint32_t& steps);
  void run_pending(TimeNs deadline);
  void end_frame(TimeNs nominal, TimeNs begin);
  /// This process has the camera and the links.
  [[nodiscard]] bool leads() const { return !stages_.empty() && number_of(0) == TimingRecord{}.id; }
  void count_load(TimeNs now, TimeNs over);
  void judge_load(TimeNs now);
  Status measure_backlog(Backlog& backlog);
  Status take_up();
  Status take_up_level();
  Status write_timing();
  void restart(std::size_t i);

  std::span<const Stage> stages_;
  std::span<Component* const> components_;
  Store& store_;
  Clock& clock_;
  EventLog events_;
  Own own_;
  Guarded<Own> own_guard_;
  const ExecutiveSetup setup_;
  Guarded<MissionParameters> parameters_guard_;
  bool restart_wanted_ = false;
  bool late_work_waits_ = false;
  bool store_locked_ = false;  ///< by another process, since
  TimeNs locked_since_ns_ = 0;
  std::size_t first_ = nobody;  ///< has waited for longest to fit into a frame: it runs in this one
  bool woken_ran_ = false;      ///< in this frame
};

}  // namespace ilp
