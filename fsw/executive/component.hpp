// The interface between the executive and a component.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "cfg/schedule.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/memory_sum.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

/// What the executive does after a step.
enum class Then : std::uint8_t {
  go_on,
  wait,     ///< the component waits for an event outside of the process: no further step in this minor frame
  keep,     ///< the work continues in the shared memory (StepMemory), which no other stage may use until it ends
  restore,  ///< memory may be ahead of the store, or invalid: call restore() before the next step
};

struct StepResult {
  Status status;         ///< a fault is reported as an event; it does not stop the component
  bool pending = false;  ///< the component has more work: call step() again as soon as time allows
  Then then = Then::go_on;
  bool set_parameters = false;  ///< the step has changed the mission's parameters
};

class Component;

/// A group of members that a component does not have.
struct NoMembers {};

/// Describes the memory of a component, so that the executive can detect unintended changes between steps. The members
/// of a component are in groups. A component declares a struct for each group that it has, and has no other members:
/// - Wiring: what the constructor received. It never changes.
/// - a cursor and a State: the content of the checkpoint. Only restore() and step() change them.
/// - Work: work that takes several steps, and counts. Only restore() and step() change it. restore() starts the work
///   again, and keeps what must last longer, such as Patience.
/// - Workspace: pixels, and data that can be derived again from records. It is not checked.
class LastingMemory {
 public:
  /// Size of Component: the pointer to its virtual functions.
  static constexpr std::size_t base_bytes = sizeof(void*);
  /// Size of a component with these groups. The only gaps are those before groups with a larger alignment.
  template <typename... Groups>
  static constexpr std::size_t bytes_with() {
    std::size_t end = base_bytes;
    const auto add = [&end](std::size_t bytes, std::size_t alignment) {
      if (alignment > alignof(void*)) end = (end + alignment - 1) / alignment * alignment;
      end += bytes;
    };
    ((std::is_same_v<Groups, NoMembers> ? void() : add(sizeof(Groups), alignof(Groups))), ...);
    return end;
  }
  /// Whether the component has these groups and no other members.
  template <typename Owner, typename... Groups>
  static constexpr bool holds_only = sizeof(Owner) == bytes_with<Groups...>();

  LastingMemory() = default;

  template <typename Owner, typename Wiring, typename Cursor, typename State, typename Work = NoMembers,
            typename Workspace = NoMembers>
  static LastingMemory of(const Owner& owner, const Wiring& wiring, const Cursor& cursor, const State& state,
                          const Work& work = {}, const Workspace& workspace = {}) {
    static_assert(holds_only<Owner, Wiring, Cursor, State, Work, Workspace>,
                  "the component has a member outside of its groups, or a group needs alignas(8)");
    static_cast<void>(workspace);
    LastingMemory memory;
    memory.object_ = octets_of(owner).first(base_bytes);
    memory.wiring_ = octets_of(wiring);
    memory.parts_ = {octets_of(cursor), octets_of(state)};
    if constexpr (!std::is_same_v<Work, NoMembers>) memory.work_ = octets_of(work);
    return memory;
  }
  /// Adds an object in the shared memory, for work that continues there (Then::keep). At most two can be added.
  template <typename Kept>
  [[nodiscard]] LastingMemory keeping(const Kept& object) const {
    LastingMemory memory = *this;
    for (std::span<const std::byte>& kept : memory.kept_) {
      if (!kept.empty()) continue;
      kept = octets_of(object);
      break;
    }
    return memory;
  }
  /// Excludes unused bytes of the state, such as the elements of a vector beyond its size.
  [[nodiscard]] LastingMemory without(std::span<const std::byte> unused) const {
    LastingMemory memory = *this;
    for (std::span<const std::byte>& part : memory.parts_) {
      const std::byte* const end = part.data() + part.size();
      if (part.empty() || unused.data() < part.data() || unused.data() + unused.size() > end) continue;
      const auto free = std::find_if(memory.parts_.begin(), memory.parts_.end(), [](auto& p) { return p.empty(); });
      if (free == memory.parts_.end()) break;
      *free = {unused.data() + unused.size(), end};
      part = {part.data(), unused.data()};
      break;
    }
    return memory;
  }
  /// Declares that a step changes cursor and state only after a commit.
  [[nodiscard]] LastingMemory changed_by_commits() const {
    LastingMemory memory = *this;
    memory.by_commits_ = true;
    return memory;
  }

  /// Declares that the next step changes neither cursor nor state.
  [[nodiscard]] LastingMemory at_rest() const {
    LastingMemory memory = *this;
    memory.at_rest_ = true;
    return memory;
  }

  [[nodiscard]] bool changes_by_commits() const { return by_commits_; }
  [[nodiscard]] bool is_at_rest() const { return at_rest_; }
  /// Checksum of the parts that never change: the wiring, and the pointer to the virtual functions.
  [[nodiscard]] std::uint64_t wiring_checksum() const { return memory_sum64(wiring_, memory_sum64(object_)); }
  /// Checksum of cursor and state.
  [[nodiscard]] std::uint64_t state_checksum() const {
    std::uint64_t sum = 0;
    for (const std::span<const std::byte> part : parts_) sum = memory_sum64(part, sum);
    return sum;
  }
  /// Checksum of cursor, state and work; `state` is their state_checksum().
  [[nodiscard]] std::uint64_t checksum(std::uint64_t state) const {
    std::uint64_t sum = memory_sum64(work_, state);
    for (const std::span<const std::byte> kept : kept_) sum = kept.empty() ? sum : memory_sum64(kept, sum);
    return sum;
  }

 private:
  template <typename Thing>
  static std::span<const std::byte> octets_of(const Thing& thing) {
    return std::as_bytes(std::span(&thing, 1));
  }

  std::array<std::span<const std::byte>, 3> parts_{};
  std::span<const std::byte> object_, wiring_, work_;
  std::array<std::span<const std::byte>, 2> kept_{};
  bool by_commits_ = false, at_rest_ = false;
};

/// A component reads and writes records, and does not know the other components.
class Component {
 public:
  Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  [[nodiscard]] virtual const char* name() const = 0;
  /// Loads the checkpoint, or starts from the beginning if there is none. Anything in memory that is not in the
  /// checkpoint is dropped. Only the executive calls it: at start-up, after a failed assertion, by command, when a step
  /// requests it, and after memory was damaged. After a fault it is called again, with growing pauses, and step() is
  /// not called until restore() has succeeded. `checkpoint_older` and `checkpoint_lost` are reports, not faults.
  virtual Status restore() = 0;
  /// Does one bounded slice of work. A transient fault (is_transient) must leave everything unchanged; step() is then
  /// called again with growing pauses.
  virtual StepResult step() = 0;
  [[nodiscard]] virtual LastingMemory lasting() const { return {}; }

 protected:
  ~Component() = default;
};
static_assert(sizeof(Component) == sizeof(void*));

struct ComponentStats {
  std::uint32_t steps = 0;
  std::uint32_t overruns = 0;  ///< steps longer than Stage::budget_ns
  std::uint32_t faults = 0;
  std::uint32_t restarts = 0;
  TimeNs busy_ns = 0;     ///< processor time of all steps
  TimeNs longest_ns = 0;  ///< processor time of the longest step
};

/// Whether restore() has succeeded with this status, which may be a report.
[[nodiscard]] constexpr bool restored(const Status& status) {
  return status.ok() || status.is(StatusCode::checkpoint_older) || status.is(StatusCode::checkpoint_lost);
}

/// The state of the components and their executive since the last start.
class Health {
 public:
  Health() = default;
  Health(const Health&) = delete;
  Health& operator=(const Health&) = delete;

  [[nodiscard]] virtual const ComponentStats& stats(ComponentId component) const = 0;
  /// Whether the component runs in this process.
  [[nodiscard]] virtual bool runs(ComponentId component) const = 0;
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
