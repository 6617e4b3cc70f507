// The cyclic executive: calls the components of a static table in fixed minor frames, gives what is left of a frame to
// whoever has pending work, counts overruns, restarts what failed, and knows no concrete component.
#pragma once

#include <array>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/schedule.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/executive/event_log.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

class Executive final : public Health {
 public:
  /// `components` in the order of `stages`; both outlive the executive.
  Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock);

  /// Restores every component; all of them are woken once.
  Status start();
  /// One minor frame: every due or woken component once in table order, then pending work until the frame ends. In
  /// virtual time the frame ends when nothing is pending. Does not sleep: the caller's clock decides when the next
  /// frame begins.
  void run_minor_frame();
  /// Nothing is pending but the time-driven components.
  [[nodiscard]] bool idle() const;

  [[nodiscard]] const ComponentStats& stats(ComponentId component) const override {
    return slots_[static_cast<std::size_t>(component)].stats;
  }
  [[nodiscard]] std::uint32_t frame_overruns() const override { return frame_overruns_; }
  [[nodiscard]] std::int64_t frames_run() const override { return frame_; }
  EventLog& events() { return events_; }
  /// Writes one ComponentRecord per component.
  Status write_housekeeping();

 private:
  struct Slot {
    bool pending = false;
    bool suspended = false;             ///< has to wait for the next minor frame
    std::uint32_t faults_in_a_row = 0;  ///< in this minor frame
    std::int64_t retry_frame = 0;       ///< found the store full: woken again in this minor frame; 0: did not
    ComponentStats stats;
  };

  void wake();
  /// Components that the ground wants to go back to their checkpoints.
  void obey_commands();
  void wait_for_store(Slot& slot) const;
  void run_step(std::size_t i, TimeNs deadline);
  void restart(std::size_t i);

  std::span<const Stage> stages_;
  std::span<Component* const> components_;
  Store& store_;
  Clock& clock_;
  EventLog events_;
  std::array<Slot, limits::max_components> slots_{};
  std::int64_t frame_ = 0;
  std::uint32_t frame_overruns_ = 0;
  std::int64_t obeyed_command_id_ = 0;
};

}  // namespace ilp
