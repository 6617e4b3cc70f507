// The cyclic executive: calls the components of a static table in fixed minor frames, gives the rest of a frame to
// components with pending work, counts overruns and restarts what failed. It knows no concrete component. A component
// steps only if it has been restored and its memory has not changed since its last step. While another process keeps
// the lock of the store, the others would work in vain, and only the time-driven ones step, when they are due.
#pragma once

#include "fsw/executive/flight_health.hpp"

namespace ilp {

class Executive final : public Health {
 public:
  /// `components` in the order of `stages`, which may be a part of the schedule; both outlive the executive.
  Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock,
            const ExecutiveSetup& setup = {});

  /// The guarded parameters were changed between two steps on purpose: other processes share the flight, and a setting
  /// came from one of them.
  void accept_parameters() { table_.accept_parameters(); }
  /// While it is set, a stage that runs only when woken waits, unless others_wait_for() it. For virtual time only.
  void put_off(bool late_work) { table_.late_work_waits = late_work; }
  /// Restores every component and wakes each of them once. A component that cannot be restored now waits and is tried
  /// again. Only faults that waiting cannot heal are returned: `store_build`, `store_schema`, `store_damaged`.
  Status start();
  /// Every component looks for work in the next minor frame, whatever was reported about changes.
  void wake_all() {
    for (ComponentSlot& slot : table_.own.slots) slot.wake();
    seal_own();
  }
  /// Runs one minor frame, which should begin at `nominal` and end a minor frame later: every due component once in
  /// table order and woken ones between them, then pending work as long as it fits. A step whose recent durations would
  /// not fit waits, and is the first of the next frame, so that no component starves. A component that keeps the shared
  /// memory steps again at once, or is the first of the next frame; the others that use this memory wait. In virtual
  /// time the frame ends when nothing is pending. It does not sleep: the caller's clock decides when the next frame
  /// begins.
  void run_minor_frame(TimeNs nominal);
  void run_minor_frame() { run_minor_frame(table_.clock.now()); }
  /// No component but the time-driven ones has pending work.
  [[nodiscard]] bool idle() const;

  [[nodiscard]] const ComponentStats& stats(ComponentId component) const override {
    static constexpr ComponentStats none;
    const std::size_t place = table_.place_of(static_cast<std::int64_t>(component));
    return place == ComponentTable::nobody ? none : table_.slot(place).stats;
  }
  [[nodiscard]] bool runs(ComponentId component) const override {
    return table_.place_of(static_cast<std::int64_t>(component)) != ComponentTable::nobody;
  }
  [[nodiscard]] std::uint32_t frame_overruns() const override { return table_.own.timing.overruns; }
  [[nodiscard]] std::int64_t frames_run() const override { return table_.own.frame; }
  EventLog& events() { return table_.events; }
  [[nodiscard]] const TimingRecord& timing() const { return table_.own.timing; }
  /// Memory was damaged that only a new process restores.
  [[nodiscard]] bool restart_wanted() const { return table_.restart_wanted; }
  /// Writes one ComponentRecord per component, and the TimingRecord.
  Status write_housekeeping() { return ilp::write_housekeeping(table_); }
  /// The flight ends: also reports events that were only counted so far.
  Status end() {
    table_.events.report_due(table_.clock.now(), true);
    return write_housekeeping();
  }

 private:
  void seal_own() { table_.own_guard.seal(table_.own); }

  ComponentTable table_;
};

}  // namespace ilp
