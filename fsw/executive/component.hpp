// What the executive calls.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "cfg/schedule.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

enum class Then : std::uint8_t {
  go_on,
  restore  ///< memory is ahead of the store, or in doubt: restore() before the next step
};

struct StepResult {
  Status status;         ///< a fault is reported as an event; it does not stop the component
  bool pending = false;  ///< more work is waiting: call again as soon as time allows
  Then then = Then::go_on;
  bool set_parameters = false;  ///< the mission's parameters are others now
};

/// Memory that nobody changes but the component itself, in step() and restore(). Not workspaces, pixels, or what is
/// made again from records. The executive notices when it has changed in between.
class LastingMemory {
 public:
  /// Cursor and state: what the checkpoint holds.
  template <typename... Things>
  explicit LastingMemory(const Things&... things) : parts_{memory_of(things)...} {}
  LastingMemory() = default;

  /// What lies in front of cursor and state in their object never changes once the flight has been put together.
  template <typename Owner>
  [[nodiscard]] LastingMemory of(const Owner& owner) const {
    LastingMemory memory = *this;
    memory.head_ = memory_between(&owner, parts_[0].data());
    return memory;
  }
  /// Of the piece of work that several steps do: from `first` to `last`, members of one object.
  template <typename First, typename Last>
  [[nodiscard]] LastingMemory at_work(const First& first, const Last& last) const {
    LastingMemory memory = *this;
    memory.work_ = memory_between(&first, &last + 1);
    return memory;
  }
  /// Cursor and state change behind a commit of the step only.
  [[nodiscard]] LastingMemory changed_by_commits() const {
    LastingMemory memory = *this;
    memory.by_commits_ = true;
    return memory;
  }

  [[nodiscard]] bool changes_by_commits() const { return by_commits_; }
  [[nodiscard]] std::uint64_t head_checksum() const { return checksum64(head_); }
  [[nodiscard]] std::uint64_t state_checksum() const {
    std::uint64_t sum = 0;
    for (const std::span<const std::byte> part : parts_) sum = checksum64(part, sum);
    return sum;
  }
  /// Of cursor, state and work; `state` is their state_checksum().
  [[nodiscard]] std::uint64_t checksum(std::uint64_t state) const { return checksum64(work_, state); }

 private:
  std::array<std::span<const std::byte>, 5> parts_{};
  std::span<const std::byte> head_, work_;
  bool by_commits_ = false;
};

/// A component reads records and writes records, and knows no other component.
class Component {
 public:
  Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  [[nodiscard]] virtual const char* name() const = 0;
  /// Loads the checkpoint, or starts afresh where there is none; anything in memory that is not in the checkpoint is
  /// forgotten. Called by the executive alone: at start-up, after a failed assertion, by command, when a step asks for
  /// it, when memory was damaged. After a fault it is called again, with growing pauses, and step() is not called until
  /// it has succeeded; `checkpoint_older` and `checkpoint_lost` are news and no faults.
  virtual Status restore() = 0;
  /// One bounded slice of work. After a fault that may pass (is_transient), with nothing changed, it is called again
  /// with growing pauses.
  virtual StepResult step() = 0;
  [[nodiscard]] virtual LastingMemory lasting() const { return {}; }

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

/// It was restored, and there is something to tell about it.
[[nodiscard]] constexpr bool restored(const Status& status) {
  return status.ok() || status.is(StatusCode::checkpoint_older) || status.is(StatusCode::checkpoint_lost);
}

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
