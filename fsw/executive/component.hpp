// What the executive calls.
#pragma once

#include "cfg/schedule.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

struct StepResult {
  Status status;         ///< a fault is reported as an event; it does not stop the component
  bool pending = false;  ///< more work is waiting: call again as soon as time allows
};

/// A component reads records and writes records, and knows no other component.
class Component {
 public:
  Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  [[nodiscard]] virtual const char* name() const = 0;
  /// Loads the checkpoint, or starts afresh where there is none. Called at start-up and after a failed assertion;
  /// anything in memory that is not in the checkpoint is forgotten.
  virtual Status restore() = 0;
  /// One bounded slice of work. `deadline` is when the slot ends; a step that would not fit may be left for the next
  /// call.
  virtual StepResult step(TimeNs deadline) = 0;

 protected:
  ~Component() = default;
};

struct ComponentStats {
  std::uint32_t steps = 0;
  std::uint32_t overruns = 0;
  std::uint32_t faults = 0;
  std::uint32_t restarts = 0;
  TimeNs busy_ns = 0;
  TimeNs longest_ns = 0;
};

/// How the components and their executive fare, since the last start.
class Health {
 public:
  Health() = default;
  Health(const Health&) = delete;
  Health& operator=(const Health&) = delete;

  [[nodiscard]] virtual const ComponentStats& stats(ComponentId component) const = 0;
  [[nodiscard]] virtual std::uint32_t frame_overruns() const = 0;
  [[nodiscard]] virtual std::int64_t frames_run() const = 0;

 protected:
  ~Health() = default;
};

}  // namespace ilp

/// ILP_ASSERT for functions that return a StepResult.
#define ILP_ASSERT_STEP(condition, value)                                                                            \
  do {                                                                                                               \
    if (!(condition)) return {::ilp::assertion_failure(__FILE__, __LINE__, static_cast<std::int64_t>(value)), true}; \
  } while (false)
