#include "fsw/executive/component_step.hpp"

#include <algorithm>

#include "fsw/base/status_values.hpp"

namespace ilp {
namespace {

/// A long step is remembered for some steps, because the component's next step may be as long.
constexpr TimeNs forget_divisor = 16;

/// Where several processes share a store, each has the lock for a moment now and then.
constexpr TimeNs shortest_lock_reported_ns = ns_per_s;

using Activity = ComponentSlot::Activity;

// Second value of memory_damaged.
constexpr auto from_checkpoint = static_cast<std::int64_t>(MemorySource::checkpoint);
constexpr auto from_copy = static_cast<std::int64_t>(MemorySource::copy);
constexpr auto from_new_process = static_cast<std::int64_t>(MemorySource::new_process);

/// Damage of what has a copy.
template <typename T>
void check(ComponentTable& table, const char* whose, Guarded<T>& guard, T& thing) {
  const GuardFinding finding = guard.check(thing);
  if (finding == GuardFinding::intact) return;
  table.restart_wanted = table.restart_wanted || finding == GuardFinding::lost;
  table.events.report(table.clock.now(), whose,
                      {StatusCode::memory_damaged, 0, finding == GuardFinding::mended ? from_copy : from_new_process});
}

void check_parameters(ComponentTable& table) {
  if (table.setup.parameters != nullptr) check(table, "parameters", table.parameters_guard, *table.setup.parameters);
}

void check_constants(ComponentTable& table) {
  if (table.restart_wanted || checksum64(table.setup.constants) == table.own.constants_checksum) return;
  table.restart_wanted = true;
  table.report({StatusCode::memory_damaged, 0, from_new_process});
}

void hold(const ComponentTable& table, ComponentSlot& slot) {
  slot.pause = std::clamp<std::int64_t>(2 * slot.pause, 1, longest_pause_frames);
  slot.hold_frame = table.own.frame + slot.pause;
}

/// The step has changed nothing and is repeated. The lock is reported once, when it is free again.
void wait_for_lock(ComponentTable& table, ComponentSlot& slot) {
  slot.wake();
  slot.suspended = true;
  table.lock.note(true, table.clock.now());
}

void seal(ComponentSlot& slot, const LastingMemory& memory, std::uint64_t state) {
  slot.state_checksum = state;
  slot.checksum = memory.checksum(state);
  // Once: the damage stays until the next process.
  if (!slot.sealed) slot.wiring_checksum = memory.wiring_checksum();
  slot.sealed = true;
}

void restart(ComponentTable& table, std::size_t i) {
  ++table.slot(i).stats.restarts;
  // A repeated attempt on this input would fail again at once, so it waits for the next minor frame.
  table.slot(i).suspended = true;
  table.report({StatusCode::component_restarted, table.number_of(i)});
  static_cast<void>(restore(table, i));
}

/// Restores the component from its checkpoint, because its memory is damaged.
void go_back(ComponentTable& table, std::size_t i) {
  table.report_of(i, {StatusCode::memory_damaged, table.number_of(i), from_checkpoint});
  restart(table, i);
  table.slot(i).wake();
}

/// Returns false, after a restore, if its memory has changed since its last step.
bool valid(ComponentTable& table, std::size_t i, const LastingMemory& memory) {
  ComponentSlot& slot = table.slot(i);
  if (memory.wiring_checksum() != slot.wiring_checksum) {
    // A restore would read its checkpoint through the damaged memory.
    table.report({StatusCode::memory_damaged, table.number_of(i), from_new_process});
    table.restart_wanted = slot.suspended = true;
    return false;
  }
  const std::uint64_t state = memory.state_checksum();
  if (state == slot.state_checksum && memory.checksum(state) == slot.checksum) return true;
  go_back(table, i);
  return false;
}

struct StepTaken {
  StepResult result;
  bool intact;  ///< false: the memory has changed during it, and a commit was refused because of that
};

/// The step itself, with its times. `memory` is what lasted before it.
StepTaken take_step(ComponentTable& table, std::size_t i, const LastingMemory& memory) {
  ComponentSlot& slot = table.slot(i);
  StepStore* const steps = table.setup.steps;
  if (steps != nullptr) steps->begin_step(memory, slot.state_checksum);
  const TimeNs begin_ns = table.clock.now();
  const TimeNs begin = table.clock.processor_time();
  const StepResult result = table.components[i]->step();
  const TimeNs used_ns = table.clock.processor_time() - begin;
  ++slot.stats.steps;
  slot.stats.busy_ns += used_ns;
  slot.stats.longest_ns = std::max(slot.stats.longest_ns, used_ns);
  if (used_ns > table.stages[i].budget_ns) ++slot.stats.overruns;
  slot.expected_ns = std::max(table.clock.now() - begin_ns, slot.expected_ns - slot.expected_ns / forget_divisor);
  if (steps != nullptr) steps->end_step();
  const LastingMemory after = table.components[i]->lasting();
  const bool watched = steps != nullptr && after.changes_by_commits();
  const bool intact = !watched || !steps->refused();
  // What has not changed keeps its checksum: if a bit has flipped meanwhile, it is found before the next step.
  const bool same = memory.is_at_rest() || (watched && !steps->committed());
  if (intact) seal(slot, after, same ? slot.state_checksum : after.state_checksum());
  if (result.set_parameters) table.accept_parameters();
  check_parameters(table);
  return {result, intact};
}

/// Returns whether it was restarted.
bool follow_fault(ComponentTable& table, std::size_t i, const Status& status) {
  ComponentSlot& slot = table.slot(i);
  // A report without severity is no fault.
  if (status_severity(status.code) != Severity::info) ++slot.stats.faults;
  // A fault may be one of many bad inputs, which are processed; an endless series is the component's own.
  if (++slot.faults_in_a_row >= max_faults_in_a_row) slot.suspended = true;
  table.report_of(i, status);
  const bool bug = status.is(StatusCode::assertion_failed) || status.is(StatusCode::cursor_back);
  if (bug) restart(table, i);
  if (status.is(StatusCode::store_full)) {
    // Nothing else would wake it: its input does not change while the store is full.
    slot.activity = Activity::full;
    slot.retry_frame = table.own.frame + full_store_retry_frames;
  } else if (is_transient(status)) {
    // Its work is not done, and its input does not change because of that.
    if (table.stages[i].period == 0 || status.is(StatusCode::store_error)) slot.wake();
    hold(table, slot);
  }
  return bug;
}

void follow(ComponentTable& table, std::size_t i, const StepResult& result) {
  ComponentSlot& slot = table.slot(i);
  bool restarted = false;
  if (result.status.ok()) {
    slot.faults_in_a_row = 0;
  } else if (result.status.is(StatusCode::store_locked)) {
    wait_for_lock(table, slot);
  } else {
    restarted = follow_fault(table, i, result.status);
  }
  if (!result.status.ok() && result.then == Then::restore && !restarted) static_cast<void>(restore(table, i));
  if (!is_transient(result.status) && slot.restored()) slot.pause = slot.hold_frame = 0;
}

/// Restores the components that the ground has commanded back to their checkpoints.
void obey_commands(ComponentTable& table) {
  if (!table.own.taken_up) return;
  CommandRecord command;
  // Bounded by the commands of one step.
  for (Status found = next(table.store, table.own.obeyed_command_id, command);
       found.ok() || found.is(StatusCode::record_damaged);
       found = next(table.store, table.own.obeyed_command_id, command)) {
    table.own.obeyed_command_id = found.ok() ? command.id : found.a;
    if (!found.ok()) continue;
    const std::size_t place = table.place_of(command.subject_id);
    if (command.kind == CommandKind::restart && place != ComponentTable::nobody) restart(table, place);
  }
}

}  // namespace

Status restore(ComponentTable& table, std::size_t i) {
  ComponentSlot& slot = table.slot(i);
  if (table.own.keeper == i) table.own.keeper = ComponentTable::nobody;
  const Status status = table.components[i]->restore();
  const std::int64_t number = table.number_of(i);
  const bool waited = slot.activity == Activity::waiting;
  if (!restored(status)) {
    ++slot.attempts;
    if (!waited) {
      table.report_of(i, {StatusCode::component_waiting, number, static_cast<std::int64_t>(status.code)});
    }
    slot.activity = Activity::waiting;
    hold(table, slot);
    return status;
  }
  if (!status.ok()) table.report_of(i, status);
  if (waited) {
    table.report_of(i, {StatusCode::component_resumed, number, slot.attempts});
    slot.pause = slot.hold_frame = 0;
    // It is not known which inputs it has missed.
    slot.activity = Activity::ready;
  } else if (slot.activity == Activity::stopped) {
    slot.activity = Activity::idle;
  }
  slot.attempts = 0;
  const LastingMemory memory = table.components[i]->lasting();
  seal(slot, memory, memory.state_checksum());
  return status;
}

void run_step(ComponentTable& table, std::size_t i) {
  check_parameters(table);
  check_constants(table);
  const LastingMemory memory = table.components[i]->lasting();
  if (!valid(table, i, memory)) return;
  const auto [result, intact] = take_step(table, i, memory);
  ComponentSlot& slot = table.slot(i);
  slot.activity = result.pending ? Activity::ready : Activity::idle;
  slot.suspended = slot.suspended || result.then == Then::wait;
  slot.left_out = 0;
  if (table.stages[i].step_memory)
    table.own.keeper = result.then == Then::keep && result.pending ? i : ComponentTable::nobody;
  if (intact) {
    follow(table, i, result);
  } else {
    go_back(table, i);
  }
  wake(table);
}

void wake(ComponentTable& table) {
  RecordMask changed = 0;
  const Status status = table.store.poll(changed);
  if (!status.ok()) table.report(status);
  for (std::size_t i = 0; i < table.stages.size(); ++i) {
    if ((table.stages[i].wakes & changed) != 0) table.slot(i).wake();
  }
  if ((changed & mask_of(RecordType::command)) != 0) obey_commands(table);
}

void check_lock(ComponentTable& table) {
  if (!table.lock.taken()) return;
  {
    Transaction transaction(table.store);
    if (transaction.begin().is(StatusCode::store_locked)) return;
  }
  const TimeNs now = table.clock.now();
  table.lock.note(false, now);
  const TimeNs taken_ns = now - table.lock.begin_ns;
  if (taken_ns < shortest_lock_reported_ns) {
    table.events.report_due(now);
  } else {
    table.events.report(now, "executive", {StatusCode::store_locked, taken_ns / ns_per_ms});
  }
}

void check_own(ComponentTable& table) {
  check(table, "executive", table.own_guard, table.own);
}

}  // namespace ilp
