// The cyclic executive: calls the components of a static table in fixed minor frames, gives the rest of a frame to
// components with pending work, counts overruns, and restores components that failed. It knows no concrete component. A
// component steps only if it has been restored and its memory has not changed since its last step. While another
// process holds the store's lock, only time-driven components step, when they are due.
#pragma once

#include "fsw/executive/flight_health.hpp"

namespace ilp {

class Executive final : public Health {
 public:
  /// `components` are in the order of `stages`, which may be a part of the schedule. Both must outlive the executive.
  Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock,
            const ExecutiveSetup& setup = {});

  /// The mission parameters were changed on purpose between two steps, by a setting from another process of the flight.
  void accept_parameters() { table_.accept_parameters(); }
  /// While `late_work` is true, stages that run only when woken wait, except those with others_wait_for(). Only for
  /// virtual time.
  void put_off(bool late_work) { table_.late_work_waits = late_work; }
  /// Restores every component and wakes it once. A component that cannot be restored waits and is tried again. Returns
  /// only faults that do not pass: `store_build`, `store_schema`, `store_damaged`.
  Status start();
  /// Wakes every component, so that each looks for work in the next minor frame.
  void wake_all() {
    for (ComponentSlot& slot : table_.own.slots) slot.wake();
    seal_own();
  }
  /// Runs one minor frame, which should begin at `nominal` and end minor_frame_ns later. First every due component and
  /// every woken one steps once, in the order of the table; then pending work is done as long as it fits. A step that
  /// is expected not to fit, from its recent durations, waits and has precedence in the next frame, so that no
  /// component starves. A component that keeps the shared memory steps again at once, or has precedence in the next
  /// frame; other users of this memory wait. In virtual time the frame ends when no work is pending. The function does
  /// not sleep: the caller decides when the next frame begins.
  void run_minor_frame(TimeNs nominal);
  void run_minor_frame() { run_minor_frame(table_.clock.now()); }
  /// Whether no component has work.
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
  /// Damaged memory can be restored only by a new process.
  [[nodiscard]] bool restart_wanted() const { return table_.restart_wanted; }
  /// Writes one ComponentRecord per component, and the TimingRecord.
  Status write_housekeeping() { return ilp::write_housekeeping(table_); }
  /// Call it at the end of the flight: reports the numbers of counted events, and writes housekeeping.
  Status end() {
    table_.events.report_due(table_.clock.now(), true);
    return write_housekeeping();
  }

 private:
  void seal_own() { table_.own_guard.seal(table_.own); }

  ComponentTable table_;
};

}  // namespace ilp
